# SPDX-License-Identifier: GPL-2.0-only
"""Detection of features in kernel headers by drivers/include/compat, and its replacements.

Each row of the table in `probe` has an artificial header here in two forms, the older and the newer
one, and a piece of a driver that requires the newer one. No version numbers are used: the kernel of
a vendor may mix the forms.
"""

import os
import re
import subprocess

import pytest

HERE = os.path.dirname(os.path.realpath(__file__))
TOP = os.path.realpath(os.path.join(HERE, '..', '..', '..'))
COMPAT = os.path.join(TOP, 'drivers/include/compat')

PRELUDE = '''
typedef unsigned char u8;
typedef unsigned long size_t;
typedef long ssize_t;
typedef int clockid_t;
#define bool _Bool
#define NULL ((void *)0)
struct tty_struct; struct tty_port; struct serdev_device; struct class_attribute;
struct workqueue_struct; struct iio_dev; struct spi_message; struct spi_controller; struct hrtimer;
enum hrtimer_restart { HRTIMER_NORESTART };
enum hrtimer_mode { HRTIMER_MODE_ABS };
struct spi_device { unsigned int mode; };
#define SPI_TX_OCTAL 1
int spi_setup(struct spi_device *spi);
'''

# macro: header, older form, newer form, use in a driver
ROWS = {
    'CLASS_ATTR_CONST': (
        'device/class.h',
        '''struct class; struct class_attribute {
	ssize_t (*show)(struct class *class, struct class_attribute *attr,
			char *buf);
	ssize_t (*store)(struct class *class, struct class_attribute *attr,
			const char *buf, size_t count); };''',
        '''struct class; struct class_attribute {
	ssize_t (*show)(const struct class *class, const struct class_attribute *attr,
			char *buf);
	ssize_t (*store)(const struct class *class, const struct class_attribute *attr,
			 const char *buf, size_t count); };''',
        '''static ssize_t attach_show(const struct class *class, const struct class_attribute *attr,
			   char *buf) { return 1; }
static ssize_t attach_store(const struct class *class, const struct class_attribute *attr,
			    const char *buf, size_t count) { return count; }
struct class_attribute driver = { .show = attach_show, .store = attach_store };'''),
    'HRTIMER_SETUP': (
        'hrtimer.h',
        '''/* hrtimer_setup() is not here */
struct hrtimer { enum hrtimer_restart (*function)(struct hrtimer *); };
extern void hrtimer_init(struct hrtimer *timer, clockid_t which_clock,
			 enum hrtimer_mode mode);''',
        '''struct hrtimer;
extern void hrtimer_setup(struct hrtimer *timer, enum hrtimer_restart (*function)(struct hrtimer *),
			  clockid_t clock_id, enum hrtimer_mode mode);''',
        '''enum hrtimer_restart end(struct hrtimer *timer);
void driver(struct hrtimer *timer) { hrtimer_setup(timer, end, 0, HRTIMER_MODE_ABS); }'''),
    'IIO_CLAIM_DIRECT': (
        'iio/iio.h',
        '''int iio_device_claim_direct_mode(struct iio_dev *indio_dev);
void iio_device_release_direct_mode(struct iio_dev *indio_dev);
/* iio_device_claim_direct_scoped() - Scoped call to iio_device_claim_direct. */
#define iio_device_claim_direct_scoped(fail, iio_dev) fail''',
        '''bool __iio_dev_mode_lock(struct iio_dev *indio_dev);
void iio_device_release_direct(struct iio_dev *indio_dev);
static inline bool iio_device_claim_direct(struct iio_dev *indio_dev)
{ return __iio_dev_mode_lock(indio_dev); }''',
        '''void driver(struct iio_dev *dev)
{ if (iio_device_claim_direct(dev)) iio_device_release_direct(dev); }'''),
    'SERDEV_RECEIVE_SIZE': (
        'serdev.h',
        '''struct serdev_device_ops {
	int (*receive_buf)(struct serdev_device *, const unsigned char *, size_t); };''',
        '''struct serdev_device_ops {
	size_t (*receive_buf)(struct serdev_device *, const u8 *, size_t); };''',
        '''static size_t xy3_serdev_receive(struct serdev_device *serdev,
                                 const u8 *data, size_t size)
{ return size; }
struct serdev_device_ops driver = { .receive_buf = xy3_serdev_receive };'''),
    'SPI_LANES': (
        'spi/spi.h', 'struct spi_transfer { const void *tx_buf; unsigned dummy_data:1; };',
        '''#define SPI_DEVICE_DATA_LANE_CNT_MAX 8
#define SPI_MULTI_LANE_MODE_SINGLE	0
#define SPI_MULTI_LANE_MODE_STRIPE	1
struct spi_transfer { const void *tx_buf; unsigned dummy_data:1;
unsigned multi_lane_mode: 2; };''',
        '''int driver_lanes(struct spi_transfer *transfer, int lanes)
{ transfer->multi_lane_mode = SPI_MULTI_LANE_MODE_SINGLE;
if (lanes > 1 && lanes <= SPI_DEVICE_DATA_LANE_CNT_MAX)
transfer->multi_lane_mode = SPI_MULTI_LANE_MODE_STRIPE;
return transfer->dummy_data; }'''),
    'SPI_NBITS_OCTAL': (
        'spi/spi.h', '#define	SPI_NBITS_QUAD	0x04', '#define	SPI_NBITS_OCTAL	0x08',
        'int driver_octal(struct spi_device *spi) { return spi_setup(spi); }'),
    'SPI_OPTIMIZE_MESSAGE': (
        'spi/spi.h',
        '''/* spi_optimize_message() is not here */
struct spi_controller { int (*prepare_message)(struct spi_controller *it, struct spi_message *msg);
int (*unprepare_message)(struct spi_controller *it, struct spi_message *msg); };''',
        '''extern int spi_optimize_message(struct spi_device *spi, struct spi_message *msg);
extern void spi_unoptimize_message(struct spi_message *msg);
struct spi_controller { int (*optimize_message)(struct spi_message *msg);
int (*unoptimize_message)(struct spi_message *msg); };''',
        '''int driver(struct spi_device *spi, struct spi_message *message)
{ spi_unoptimize_message(message); return spi_optimize_message(spi, message); }
static int sim_optimize(struct spi_message *message) { return 0; }
static int sim_unoptimize(struct spi_message *message) { return 0; }
void controller(struct spi_controller *it)
{ it->optimize_message = sim_optimize; it->unoptimize_message = sim_unoptimize; }'''),
    'SYSTEM_DFL_WQ': (
        'workqueue.h',
        '/* system_dfl_wq; */ extern struct workqueue_struct *system_unbound_wq;',
        'extern struct workqueue_struct *system_dfl_wq;',
        'struct workqueue_struct *driver_dfl(void) { return system_dfl_wq; }'),
    'SYSTEM_PERCPU_WQ': (
        'workqueue.h',
        'extern struct workqueue_struct *system_wq; /* use system_percpu_wq */',
        'extern struct workqueue_struct *system_percpu_wq;',
        'struct workqueue_struct *driver_percpu(void) { return system_percpu_wq; }'),
    'TTY_LDISC_RECEIVE_SIZE': (
        'tty_ldisc.h',
        '''struct tty_ldisc_ops { ssize_t	(*read)(struct tty_struct *tty, size_t nr);
	void	(*receive_buf)(struct tty_struct *tty, const unsigned char *cp,
			       const char *fp, int count); };''',
        '''struct tty_ldisc_ops { ssize_t	(*read)(struct tty_struct *tty, size_t nr);
	void	(*receive_buf)(struct tty_struct *tty, const u8 *cp,
			       const u8 *fp, size_t count); };''',
        '''static void xy3_ldisc_receive(struct tty_struct *tty, const u8 *data, const u8 *flags,
			      size_t count) { }
struct tty_ldisc_ops driver = { .receive_buf = xy3_ldisc_receive };'''),
    'TTY_PORT_RECEIVE_SIZE': (
        'tty_port.h',
        '''struct tty_port_client_operations { int (*receive_buf)(struct tty_port *port,
	const unsigned char *, const unsigned char *, size_t); };''',
        '''struct tty_port_client_operations {
	size_t (*receive_buf)(struct tty_port *port, const u8 *cp, const u8 *fp,
			      size_t count); };''',
        '''static size_t xy3_receive_buf(struct tty_port *port, const u8 *data, const u8 *flags,
			      size_t count) { return count; }
struct tty_port_client_operations driver = { .receive_buf = xy3_receive_buf };'''),
    'TTY_WRITE_SIZE': (
        'tty_driver.h',
        'struct tty_operations {'
        ' int  (*write)(struct tty_struct *tty, const u8 *buf, int count); };',
        'struct tty_operations {'
        ' ssize_t (*write)(struct tty_struct *tty, const u8 *buf, size_t count); };',
        '''static ssize_t xy3_write(struct tty_struct *tty, const u8 *data, size_t size)
{ return 1; }
struct tty_operations driver = { .write = xy3_write };
static ssize_t sim_write(struct tty_struct *tty, const u8 *data, size_t size) { return size; }
struct tty_operations virtual = { .write = sim_write };'''),
    'UNALIGNED': (
        'unaligned.h', None, 'u8 get_unaligned(const u8 *place);',
        'int driver(const u8 *place) { return get_unaligned(place); }'),
}


def kernel(folder, newer):
    """Headers in which these rows have the newer form, and all others the older one"""
    headers = {}
    for name, (header, old, new, _) in ROWS.items():
        text = new if name in newer else old
        if text is not None:
            headers.setdefault('linux/' + header, []).append(text)
    headers['asm/unaligned.h'] = [ROWS['UNALIGNED'][2]]
    for header, texts in headers.items():
        path = folder / header
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text('\n'.join(texts) + '\n', encoding='ascii')
    return folder


def probe(headers):
    done = subprocess.run(['sh', os.path.join(COMPAT, 'probe'), headers / 'linux'],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=True)
    assert done.stderr == ''
    return done.stdout.split()


def macros(names):
    return ['-DKERNEL_HAS_' + name for name in names]


def compiles(name, headers, *options):
    header, use = ROWS[name][0], ROWS[name][3]
    source = '%s\n#include <linux/%s>\n%s\n' % (PRELUDE, header, use)
    return subprocess.run(
        ['gcc', '-x', 'c', '-std=gnu11', '-nostdinc', '-Wall', '-Werror', '-fsyntax-only',
         *options, '-I', headers, '-'],
        input=source, text=True, stderr=subprocess.PIPE, check=False)


@pytest.mark.parametrize('name', ROWS)
def test_one_new_form_among_old_ones_is_found(name, tmp_path):
    assert probe(kernel(tmp_path, {name})) == macros([name])


@pytest.mark.parametrize('name', ROWS)
def test_one_old_form_among_new_ones_is_found(name, tmp_path):
    others = [other for other in ROWS if other != name]
    assert probe(kernel(tmp_path, set(others))) == macros(others)


@pytest.mark.parametrize('name', ROWS)
def test_driver_in_the_new_form_compiles_with_both(name, tmp_path):
    for newer in set(), {name}, set(ROWS) - {name}, set(ROWS):
        headers = kernel(tmp_path / str(len(newer)), newer)
        done = compiles(name, headers, '-I', COMPAT, *probe(headers))
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize('name', [name for name in ROWS if name != 'SPI_NBITS_OCTAL'])
def test_old_form_is_no_use_to_the_driver(name, tmp_path):
    """Counterpart of the previous test: it fails without the shadow header"""
    assert compiles(name, kernel(tmp_path, set())).returncode != 0
    new = kernel(tmp_path / 'new', {name})
    done = compiles(name, new)
    assert done.returncode == 0, done.stderr


def test_device_gets_eight_lines_where_transfers_have_them(tmp_path):
    program = tmp_path / 'program'
    main = '''int spi_setup(struct spi_device *spi) { return 0; }
#include <linux/spi/spi.h>
int main(void)
{ struct spi_device spi = { .mode = SPI_TX_OCTAL }; spi_setup(&spi); return spi.mode; }'''
    for newer, mode in (set(), 0), ({'SPI_NBITS_OCTAL'}, 1):
        headers = kernel(tmp_path / str(mode), newer)
        subprocess.run(['gcc', '-x', 'c', '-nostdinc', '-I', COMPAT, *probe(headers),
                        '-I', headers, '-o', program, '-'],
                       input=PRELUDE + main, text=True, check=True)
        assert subprocess.run([program], check=False).returncode == mode


def test_each_macro_has_a_row_and_a_header_that_asks_for_it():
    with open(os.path.join(COMPAT, 'probe'), encoding='ascii') as file:
        table = re.findall(r'^\t([A-Z_]+)\t+([a-z_/]+\.h)\t', file.read(), re.M)
    assert table == [(name, row[0]) for name, row in ROWS.items()]
    asked = set()
    for folder, _, files in os.walk(os.path.join(COMPAT, 'linux')):
        for name in files:
            with open(os.path.join(folder, name), encoding='ascii') as file:
                asked |= set(re.findall(r'KERNEL_HAS_(\w+)', file.read()))
    assert asked == set(ROWS)
