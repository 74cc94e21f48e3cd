#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""xy3_metrics.py [-o FILE]: metrics of scanheads for Prometheus, from `xy3ctl show --json'.

Standard input has one document per line. FILE is for the textfile collector of node_exporter, in
Debian /var/lib/prometheus/node-exporter/xy3.prom; it is replaced as a whole, and never seen half
written. The default is standard output.
"""

import argparse
import json
import os
import sys

# name: (type, help)
METRICS = {
    'xy3_info': ('gauge', 'Identity of the head, always 1'),
    'xy3_in_sync': ('gauge', 'Whether packets are being received from the head'),
    'xy3_rate_bits_per_second': ('gauge', 'Rate of the backchannel'),
    'xy3_temperature_celsius': ('gauge', 'Temperatures that the head reports'),
    'xy3_error': ('gauge', 'Errors that the head reports, each 1'),
    'xy3_operating_hours': ('gauge', 'Hours of operation that the head reports'),
    'xy3_frame_errors': ('gauge', 'Bad frames that the head has counted since its power-on'),
    'xy3_backchannel_total': ('counter', 'Counters of the backchannel'),
    'xy3_forward_total': ('counter', 'Counters of the forward channel'),
    'xy3_forward_frames_per_second': ('gauge', 'Rates of the forward channel'),
}
IDENTITY = ('vendor', 'model', 'firmware', 'serial')
FREQUENCIES = ('sampling_frequency', 'achieved_frequency')


def samples(document):
    """Yields (metric, labels, value) of a head."""
    stream = document['stream'] or {}
    yield 'xy3_info', {name: document[name] or '' for name in IDENTITY}, 1
    yield 'xy3_in_sync', {}, int(document['in_sync'])
    if document['rate'] is not None:
        yield 'xy3_rate_bits_per_second', {}, document['rate']
    for component, value in document['temperature'].items():
        yield 'xy3_temperature_celsius', {'component': component}, value
    for component, error in document['errors'].items():
        yield 'xy3_error', {'component': component, 'error': error}, 1
    for component, hours in document['hours'].items():
        yield 'xy3_operating_hours', {'component': component}, hours
    for axis, count in document['frame_errors'].items():
        yield 'xy3_frame_errors', {'axis': axis}, count
    for name, count in document['statistics'].items():
        yield 'xy3_backchannel_total', {'counter': name}, count
    for name, number in stream.items():
        if name in FREQUENCIES:
            yield 'xy3_forward_frames_per_second', {'kind': name.partition('_')[0]}, number
        elif name != 'frame_bits':
            yield 'xy3_forward_total', {'counter': name}, number


def quote(text):
    return '"%s"' % text.replace('\\', r'\\').replace('"', r'\"').replace('\n', r'\n')


def text(documents):
    """All samples in Prometheus' text format, those of a metric together"""
    lines = {name: [] for name in METRICS}
    for document in documents:
        for name, labels, value in samples(document):
            labels = {'head': document['head'], **labels}
            lines[name].append('%s{%s} %s\n' % (
                name, ','.join('%s=%s' % (key, quote(label)) for key, label in labels.items()),
                value))
    return ''.join('# HELP %s %s\n# TYPE %s %s\n' % (name, about, name, kind) + ''.join(lines[name])
                   for name, (kind, about) in METRICS.items() if lines[name])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('-o', '--output', metavar='FILE', help='for node_exporter, named *.prom')
    options = parser.parse_args()
    documents = [json.loads(line) for line in sys.stdin]
    metrics = text(document for document in documents if 'error' not in document)
    if not options.output:
        sys.stdout.write(metrics)
        return
    with open(options.output + '.new', 'w', encoding='utf-8') as file:
        file.write(metrics)
    os.replace(options.output + '.new', options.output)


if __name__ == '__main__':
    main()
