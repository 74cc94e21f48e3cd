# SPDX-License-Identifier: GPL-2.0-only
"""The models of xhc-sim that the driver supports; xhc-sim may support more."""

from xhc_sim import models

MODELS = {name: models.MODELS[name] for name in ('HB03', 'HB04', 'WHB04B')}
