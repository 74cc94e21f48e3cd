# SPDX-License-Identifier: GPL-2.0-only
"""The models of xhc-sim that the driver binds: xhc-sim may be ahead of the driver."""

from xhc_sim import models

MODELS = {name: models.MODELS[name] for name in ('HB03', 'HB04', 'WHB04B')}
