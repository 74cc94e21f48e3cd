/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * XHC pendant: tracepoints xhc:xhc_report and xhc:xhc_frame
 */
#undef TRACE_SYSTEM
#define TRACE_SYSTEM xhc

#if !defined(XHC_TRACE_H) || defined(TRACE_HEADER_MULTI_READ)
#define XHC_TRACE_H

#include <linux/hid.h>
#include <linux/string.h>
#include <linux/tracepoint.h>

#define XHC_TRACE_NAME_SIZE	32	/* a HID device's name: "0003:10CE:EB70.0001" */

DECLARE_EVENT_CLASS(xhc_bytes,
	TP_PROTO(const struct hid_device *hdev, const u8 *data, size_t size, int error),
	TP_ARGS(hdev, data, size, error),
	TP_STRUCT__entry(
		__array(char, name, XHC_TRACE_NAME_SIZE)
		__field(int, error)
		__dynamic_array(u8, data, size)
	),
	TP_fast_assign(
		strscpy(__entry->name, dev_name(&hdev->dev), XHC_TRACE_NAME_SIZE);
		__entry->error = error;
		memcpy(__get_dynamic_array(data), data, size);
	),
	TP_printk("%s error=%d data=%s", __entry->name, __entry->error,
		  __print_hex(__get_dynamic_array(data), __get_dynamic_array_len(data)))
);

/* An input report as received; error is the result of decoding it */
DEFINE_EVENT(xhc_bytes, xhc_report,
	TP_PROTO(const struct hid_device *hdev, const u8 *data, size_t size, int error),
	TP_ARGS(hdev, data, size, error)
);

/* The payload of a display frame, after its last transfer; error is that of the transfer */
DEFINE_EVENT(xhc_bytes, xhc_frame,
	TP_PROTO(const struct hid_device *hdev, const u8 *data, size_t size, int error),
	TP_ARGS(hdev, data, size, error)
);

#endif /* XHC_TRACE_H */

#undef TRACE_INCLUDE_PATH
#define TRACE_INCLUDE_PATH .
#undef TRACE_INCLUDE_FILE
#define TRACE_INCLUDE_FILE trace
#include <trace/define_trace.h>
