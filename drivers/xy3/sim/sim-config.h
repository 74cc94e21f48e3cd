/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Virtual XY3-100 compatible scanhead: the kind of head and controller
 */
#ifndef XY3_SIM_CONFIG_H
#define XY3_SIM_CONFIG_H

#include <linux/types.h>

#define XY3_SIM_LINES_MAX	8
#define XY3_SIM_AXES		5
#define XY3_SIM_SIGNALS_MAX	48	/* of the text with their names */
#define XY3_SIM_NAME_MAX	32	/* of drivers and devices, as in the SPI core */

/**
 * enum xy3_sim_framing - the signal used as SYNC
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
 * @XY3_SIM_MODES_0: it has neither clock phase nor polarity (spi-stm32-qspi)
 * @XY3_SIM_MODES_CLAIMED: it accepts all, and uses mode 0 for 1 and 2 (spi-tegra210-quad)
 */
enum xy3_sim_modes {
	XY3_SIM_MODES_ALL,
	XY3_SIM_MODES_0_3,
	XY3_SIM_MODES_0,
	XY3_SIM_MODES_CLAIMED,
};

/**
 * enum xy3_sim_idle - the data lines between messages, while there is no clock
 * @XY3_SIM_IDLE_KEEP: each keeps its last level
 * @XY3_SIM_IDLE_LOW: low
 * @XY3_SIM_IDLE_HIGH: high
 * @XY3_SIM_IDLE_FLOAT: they are not driven: each is at any level, except a gate, which is low
 */
enum xy3_sim_idle {
	XY3_SIM_IDLE_KEEP,
	XY3_SIM_IDLE_LOW,
	XY3_SIM_IDLE_HIGH,
	XY3_SIM_IDLE_FLOAT,
};

/**
 * enum xy3_sim_clock - the actual clock of the controller for a requested one
 * @XY3_SIM_CLOCK_ANY: the same
 * @XY3_SIM_CLOCK_DIVIDED: the highest one divided by a whole number, rounded down (spi-bcm2835)
 * @XY3_SIM_CLOCK_HALVED: the highest one divided by a power of two, rounded down (spi-stm32)
 * @XY3_SIM_CLOCK_SETUP: that of the device when it was set up (spi-stm32-qspi)
 * @XY3_SIM_CLOCK_FIXED: the highest one (spi-xilinx)
 */
enum xy3_sim_clock {
	XY3_SIM_CLOCK_ANY,
	XY3_SIM_CLOCK_DIVIDED,
	XY3_SIM_CLOCK_HALVED,
	XY3_SIM_CLOCK_SETUP,
	XY3_SIM_CLOCK_FIXED,
};

/**
 * enum xy3_sim_signal - the signal of a data line
 * @XY3_SIM_X: axis X; Y, Z, U and W follow
 * @XY3_SIM_SYNC: SYNC
 * @XY3_SIM_GATE: the gate of the laser
 * @XY3_SIM_NONE: unused
 */
enum xy3_sim_signal {
	XY3_SIM_X,
	XY3_SIM_SYNC = XY3_SIM_AXES,
	XY3_SIM_GATE,
	XY3_SIM_NONE
};

/**
 * struct xy3_sim_config - the settings of a head, from module parameters and configfs
 * @lines: data lines of the controller: 1, 2, 4 or 8
 * @device_lines: data lines of the SPI device in firmware, 0 for the same number
 * @framing: by enum xy3_sim_framing
 * @signals: names of the signals of the lines; empty for the default of @framing
 * @signal: the signal of each line, by enum xy3_sim_signal; parsed from @signals
 * @cs_word: the controller can toggle the chip select after each word
 * @max_speed_hz: of the controller and the device
 * @min_speed_hz: of the controller, 0 for any
 * @clock: supported clocks, by enum xy3_sim_clock
 * @max_transfer: longest transfer in bytes, 0 for any
 * @max_message: longest message in bytes, 0 for any
 * @modes: SPI modes of the controller, by enum xy3_sim_modes
 * @clock_inverted: the pair of CLK is crossed, also in firmware
 * @word_bits: longest word with @cs_word or @lanes
 * @driven_lines: data lines that transfers actually use, 0 for all
 * @flash_only: no plain transfers, spi-mem only
 * @lsb_first: the lowest bit is first in firmware
 * @lanes: lanes, of one line each, instead of a bus width; 0 for none
 * @idle: the data lines between messages, by enum xy3_sim_idle
 * @turnaround_us: time between two consecutive messages
 * @prepare_us: time to prepare a message, 0 if the controller does not prepare messages
 * @driver: name of the driver of the controller
 * @modalias: of the SPI device
 * @realtime: transfers take the same time as on a wire
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

/**
 * enum xy3_sim_kind - the kinds of settings
 * @XY3_SIM_KIND_NUMBER: a number
 * @XY3_SIM_KIND_FLAG: yes or no
 * @XY3_SIM_KIND_CHOICE: one of several names
 * @XY3_SIM_KIND_TEXT: a text
 */
enum xy3_sim_kind {
	XY3_SIM_KIND_NUMBER,
	XY3_SIM_KIND_FLAG,
	XY3_SIM_KIND_CHOICE,
	XY3_SIM_KIND_TEXT,
};

/**
 * struct xy3_sim_setting - a setting
 * @kind: the type of its member in struct xy3_sim_config
 * @offset: offset of the member
 * @size: size of the member
 * @min: lowest number
 * @max: highest number, or number of names
 * @names: of a choice
 */
struct xy3_sim_setting {
	enum xy3_sim_kind kind;
	size_t offset;
	size_t size;
	unsigned int min;
	unsigned int max;
	const char * const *names;
};

/* sim-config.c */
extern struct xy3_sim_config xy3_sim_defaults;
int xy3_sim_setting_parse(const struct xy3_sim_setting *setting, struct xy3_sim_config *config,
			  const char *text);
int xy3_sim_setting_print(const struct xy3_sim_setting *setting,
			  const struct xy3_sim_config *config, char *page);
int xy3_sim_config_resolve(struct xy3_sim_config *config);
int xy3_sim_parse_signals(const char *text, unsigned int lines, u8 *signal);
const char *xy3_sim_signal_name(u8 signal);

/* sim-configfs.c */
int xy3_sim_configfs_init(void);
void xy3_sim_configfs_exit(void);

#endif /* XY3_SIM_CONFIG_H */
