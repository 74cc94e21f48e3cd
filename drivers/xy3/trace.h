/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * XY3-100 scanhead: tracepoints xy3:xy3_packet, xy3:xy3_sync and xy3:xy3_frame
 */
#undef TRACE_SYSTEM
#define TRACE_SYSTEM xy3

#if !defined(XY3_TRACE_H) || defined(TRACE_HEADER_MULTI_READ)
#define XY3_TRACE_H

#include <linux/string.h>
#include <linux/tracepoint.h>

/* A packet of the backchannel */
TRACE_EVENT(xy3_packet,
	TP_PROTO(unsigned int number, u8 type, const u8 *payload, size_t length),
	TP_ARGS(number, type, payload, length),
	TP_STRUCT__entry(
		__field(unsigned int, number)
		__field(u8, type)
		__dynamic_array(u8, payload, length)
	),
	TP_fast_assign(
		__entry->number = number;
		__entry->type = type;
		memcpy(__get_dynamic_array(payload), payload, length);
	),
	TP_printk("xy3-%u type=%02x length=%d payload=%s", __entry->number, __entry->type,
		  __get_dynamic_array_len(payload),
		  __print_hex(__get_dynamic_array(payload), __get_dynamic_array_len(payload)))
);

/* Sync was lost or found; dropped is the total number of bytes that are not part of a packet */
TRACE_EVENT(xy3_sync,
	TP_PROTO(unsigned int number, bool in_sync, u64 dropped),
	TP_ARGS(number, in_sync, dropped),
	TP_STRUCT__entry(
		__field(unsigned int, number)
		__field(bool, in_sync)
		__field(u64, dropped)
	),
	TP_fast_assign(
		__entry->number = number;
		__entry->in_sync = in_sync;
		__entry->dropped = dropped;
	),
	TP_printk("xy3-%u in_sync=%d dropped=%llu", __entry->number, __entry->in_sync,
		  __entry->dropped)
);

/* Command frames on their way to the head; error is the result from the forward channel */
TRACE_EVENT(xy3_frame,
	TP_PROTO(unsigned int number, const u8 *frames, size_t size, int error),
	TP_ARGS(number, frames, size, error),
	TP_STRUCT__entry(
		__field(unsigned int, number)
		__field(int, error)
		__dynamic_array(u8, frames, size)
	),
	TP_fast_assign(
		__entry->number = number;
		__entry->error = error;
		memcpy(__get_dynamic_array(frames), frames, size);
	),
	TP_printk("xy3-%u error=%d frames=%s", __entry->number, __entry->error,
		  __print_hex(__get_dynamic_array(frames), __get_dynamic_array_len(frames)))
);

#endif /* XY3_TRACE_H */

#undef TRACE_INCLUDE_PATH
#define TRACE_INCLUDE_PATH .
#undef TRACE_INCLUDE_FILE
#define TRACE_INCLUDE_FILE trace
#include <trace/define_trace.h>
