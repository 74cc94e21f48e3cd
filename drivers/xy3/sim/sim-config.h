/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Virtual XY3-100 compatible scanhead: what kind of head and controller it is
 */
#ifndef XY3_SIM_CONFIG_H
#define XY3_SIM_CONFIG_H

#include <linux/types.h>

#define XY3_SIM_LINES_MAX	8
#define XY3_SIM_AXES		5
#define XY3_SIM_SIGNALS_MAX	48	/* of the text that names them */
#define XY3_SIM_NAME_MAX	32	/* of drivers and devices, as in the SPI core */

struct config_item;
struct configfs_attribute;

/**
 * enum xy3_sim_framing - what SYNC is
 * @XY3_SIM_FRAMING_CS: the chip select
 * @XY3_SIM_FRAMING_LINE: a data line
 */
enum xy3_sim_framing {
	XY3_SIM_FRAMING_CS,
	XY3_SIM_FRAMING_LINE,
};

/**
 * enum xy3_sim_modes - SPI modes of the controller
 * @XY3_SIM_MODES_ALL: 0 to 3
 * @XY3_SIM_MODES_0_3: 0 and 3; it refuses the others (spi-qcom-qspi and many that read flash)
 * @XY3_SIM_MODES_0: it has no clock phase nor polarity (spi-stm32-qspi)
 * @XY3_SIM_MODES_CLAIMED: it takes them all, and does mode 0 for 1 and 2 (spi-tegra210-quad)
 */
enum xy3_sim_modes {
	XY3_SIM_MODES_ALL,
	XY3_SIM_MODES_0_3,
	XY3_SIM_MODES_0,
	XY3_SIM_MODES_CLAIMED,
};

/**
 * enum xy3_sim_idle - the data lines between messages, while the clock stands still
 * @XY3_SIM_IDLE_KEEP: each keeps its last level
 * @XY3_SIM_IDLE_LOW: low
 * @XY3_SIM_IDLE_HIGH: high
 * @XY3_SIM_IDLE_FLOAT: nothing drives them: each is at any level, a gate's is low
 */
enum xy3_sim_idle {
	XY3_SIM_IDLE_KEEP,
	XY3_SIM_IDLE_LOW,
	XY3_SIM_IDLE_HIGH,
	XY3_SIM_IDLE_FLOAT,
};

/**
 * enum xy3_sim_clock - clocks that the controller has, of those that it is asked for
 * @XY3_SIM_CLOCK_ANY: any
 * @XY3_SIM_CLOCK_DIVIDED: its highest one by a whole number, the next lower one (spi-bcm2835)
 * @XY3_SIM_CLOCK_HALVED: its highest one by a power of two, the next lower one (spi-stm32)
 * @XY3_SIM_CLOCK_SETUP: that of the device when it was set up (spi-stm32-qspi)
 * @XY3_SIM_CLOCK_FIXED: its highest one (spi-xilinx)
 */
enum xy3_sim_clock {
	XY3_SIM_CLOCK_ANY,
	XY3_SIM_CLOCK_DIVIDED,
	XY3_SIM_CLOCK_HALVED,
	XY3_SIM_CLOCK_SETUP,
	XY3_SIM_CLOCK_FIXED,
};

/**
 * enum xy3_sim_signal - what a data line carries
 * @XY3_SIM_X: axis X; Y, Z, U and W follow
 * @XY3_SIM_SYNC: SYNC
 * @XY3_SIM_GATE: the laser's gate
 * @XY3_SIM_NONE: nothing
 */
enum xy3_sim_signal {
	XY3_SIM_X,
	XY3_SIM_SYNC = XY3_SIM_AXES,
	XY3_SIM_GATE,
	XY3_SIM_NONE
};

/**
 * struct xy3_sim_config - the settings of a head, as module parameters and configfs have them
 * @lines: data lines of the controller: 1, 2, 4 or 8
 * @device_lines: data lines that the SPI device is said to have, 0 for as many
 * @framing: by enum xy3_sim_framing
 * @signals: names of what the lines carry; nothing for what goes with @framing
 * @signal: what each line carries, by enum xy3_sim_signal; it follows from @signals
 * @cs_word: the controller can move the chip select after each word
 * @max_speed_hz: of the controller and the device
 * @min_speed_hz: of the controller, 0 for any
 * @clock: clocks that it has, by enum xy3_sim_clock
 * @max_transfer: longest transfer in bytes, 0 for any
 * @max_message: longest message in bytes, 0 for any
 * @modes: SPI modes of the controller, by enum xy3_sim_modes
 * @clock_inverted: the pair of CLK is crossed, and firmware says so
 * @word_bits: longest word with @cs_word or @lanes
 * @driven_lines: data lines that transfers really use, 0 for all
 * @flash_only: no plain transfers, spi-mem only
 * @lsb_first: firmware says that the lowest bit goes first
 * @lanes: lanes, of one line each, in place of a bus width; 0 for none
 * @idle: the data lines between messages, by enum xy3_sim_idle
 * @turnaround_us: time between two messages that follow one another
 * @prepare_us: time to prepare a message, 0 when the controller does not prepare any
 * @driver: name of the controller's driver
 * @modalias: of the SPI device
 * @realtime: transfers take the time that they take on a wire
 * @uart_max: highest speed of the UART in bit/s
 * @interval_ms: between rounds of telemetry, 0 for none
 * @sync_ms: between sync packets, 0 for none
 * @seed: of random faults
 */
struct xy3_sim_config {
	unsigned int lines;
	unsigned int device_lines;
	unsigned int framing;
	char signals[XY3_SIM_SIGNALS_MAX];
	u8 signal[XY3_SIM_LINES_MAX];
	bool cs_word;
	unsigned int max_speed_hz;
	unsigned int min_speed_hz;
	unsigned int clock;
	unsigned int max_transfer;
	unsigned int max_message;
	unsigned int modes;
	bool clock_inverted;
	unsigned int word_bits;
	unsigned int driven_lines;
	bool flash_only;
	bool lsb_first;
	unsigned int lanes;
	unsigned int idle;
	unsigned int turnaround_us;
	unsigned int prepare_us;
	char driver[XY3_SIM_NAME_MAX];
	char modalias[XY3_SIM_NAME_MAX];
	bool realtime;
	unsigned int uart_max;
	unsigned int interval_ms;
	unsigned int sync_ms;
	unsigned int seed;
};

struct xy3_sim_setting;

/* sim-config.c */
extern struct xy3_sim_config xy3_sim_defaults;
extern struct configfs_attribute *xy3_sim_config_attrs[];
int xy3_sim_setting_parse(const struct xy3_sim_setting *setting, struct xy3_sim_config *config,
			  const char *text);
int xy3_sim_setting_print(const struct xy3_sim_setting *setting,
			  const struct xy3_sim_config *config, char *page);
int xy3_sim_config_resolve(struct xy3_sim_config *config);
int xy3_sim_parse_signals(const char *text, unsigned int lines, u8 *signal);
const char *xy3_sim_signal_name(u8 signal);

/* sim-configfs.c */
ssize_t xy3_sim_configfs_show(struct config_item *item, const struct xy3_sim_setting *setting,
			      char *page);
ssize_t xy3_sim_configfs_store(struct config_item *item, const struct xy3_sim_setting *setting,
			       const char *page, size_t count);
ssize_t xy3_sim_number_show(struct config_item *item, char *page);
ssize_t xy3_sim_live_show(struct config_item *item, char *page);
ssize_t xy3_sim_live_store(struct config_item *item, const char *page, size_t count);
int xy3_sim_configfs_init(void);
void xy3_sim_configfs_exit(void);

#endif /* XY3_SIM_CONFIG_H */
