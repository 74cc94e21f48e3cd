// SPDX-License-Identifier: GPL-2.0-only
/*
 * XHC pendant (HB03, HB04, WHB04B): the HID driver
 *
 * A hand-held jog wheel with keys, a selector and a display, for CNC machines. Reports
 * become evdev events, and the display is written through sysfs; hidraw stays available.
 *
 * This is the only file that calls the HID core.
 */

#include <linux/hid.h>
#include <linux/module.h>
#include <linux/pm.h>
#include <linux/suspend.h>

#include "xhc.h"

#define CREATE_TRACE_POINTS
#include "trace.h"

static bool swap_feed_spindle;
module_param(swap_feed_spindle, bool, 0644);
MODULE_PARM_DESC(swap_feed_spindle,
		 "Default of the attribute of this name: exchange the selector positions feed and spindle (default: N)");

/*
 * Send a feature report and wait until the pendant has accepted it.
 *
 * Return: 0 on success, -EPIPE if the pendant stalled it, -ETIMEDOUT if it did not respond,
 * -ENODEV if it was removed or is suspended, -ENOMEM, or -EIO for any other failure.
 */
static int xhc_send_report(struct xhc_device *xhc, u8 *report)
{
	int ret = hid_hw_raw_request(xhc->hdev, report[0], report, XHC_CHUNK_SIZE,
				     HID_FEATURE_REPORT, HID_REQ_SET_REPORT);

	switch (ret) {
	case XHC_CHUNK_SIZE:
		return 0;
	case -EPIPE:
	case -ETIMEDOUT:
	case -ENOMEM:
		return ret;
	case -ENODEV:
	case -ENOENT:		/* the transfer was cancelled */
	case -ESHUTDOWN:	/* the bus was removed */
	case -EHOSTUNREACH:	/* the device is suspended */
		return -ENODEV;
	default:
		return -EIO;
	}
}

static int xhc_raw_event(struct hid_device *hdev, struct hid_report *report, u8 *data, int size)
{
	struct xhc_device *xhc = hid_get_drvdata(hdev);
	struct xhc_input_state in;
	int err;

	if (report->type != HID_INPUT_REPORT)
		return 0;

	err = xhc_decode_report(xhc->model, data, size,
				READ_ONCE(xhc->swap_feed_spindle), &in);
	trace_xhc_report(hdev, data, size, err);

	xhc_count(xhc, XHC_REPORTS);
	if (err) {
		xhc_count(xhc, XHC_BAD_REPORTS);
		return 0;
	}
	if (xhc_input_trailing(xhc, &in))
		return 0;
	if (!in.asleep && !xhc_dro_report(xhc, data, in.day))
		xhc_count(xhc, XHC_XOR_MISMATCHES);

	/* a wireless pendant misses the frames that are sent while it is asleep */
	if (xhc_input_emit(xhc, &in))
		xhc_dro_lost(xhc);
	return 0;	/* pass it on to hidraw */
}

/*
 * Refuse a device whose descriptor lacks the two reports that the driver relies on. The sizes are
 * compared in bits: hid_validate_values() counts values, whatever their size.
 */
static int xhc_check_reports(struct hid_device *hdev, const struct xhc_model *model)
{
	const struct hid_report *input =
		hdev->report_enum[HID_INPUT_REPORT].report_id_hash[XHC_INPUT_ID];
	struct hid_report *feature =
		hdev->report_enum[HID_FEATURE_REPORT].report_id_hash[XHC_FEATURE_ID];

	if (input && input->size == 8 * (model->report_size - 1) &&
	    feature && feature->size >= 8 * XHC_CHUNK_PAYLOAD)
		return 0;

	hid_err(hdev, "not the report descriptor of a pendant\n");
	return -ENODEV;
}

/*
 * The input core releases pressed keys on suspend, before the HID device is suspended, but it
 * does not reset axes such as the selector. Release all of them here, in one report and while
 * programs still run and can see it. Reports are accepted again after xhc_resume(), or by
 * this notifier if the suspend was aborted before it reached the pendant.
 */
static int xhc_pm_notify(struct notifier_block *pm_nb, unsigned long event, void *unused)
{
	struct xhc_device *xhc = container_of(pm_nb, struct xhc_device, pm_nb);

	switch (event) {
	case PM_SUSPEND_PREPARE:
	case PM_HIBERNATION_PREPARE:
	case PM_RESTORE_PREPARE:
		xhc_input_stop(xhc);
		break;
	case PM_POST_SUSPEND:
	case PM_POST_HIBERNATION:
	case PM_POST_RESTORE:
		xhc_input_start(xhc);
		break;
	}
	return NOTIFY_DONE;
}

static int xhc_probe(struct hid_device *hdev, const struct hid_device_id *id)
{
	struct xhc_device *xhc;
	int err;

	xhc = devm_kzalloc(&hdev->dev, sizeof(*xhc), GFP_KERNEL);
	if (!xhc)
		return -ENOMEM;
	xhc->hdev = hdev;
	xhc->model = xhc_model_find(id->driver_data);
	if (!xhc->model)
		return -ENODEV;
	xhc->swap_feed_spindle = swap_feed_spindle;
	hid_set_drvdata(hdev, xhc);

	err = hid_parse(hdev);
	if (err)
		return err;
	err = xhc_check_reports(hdev, xhc->model);
	if (err)
		return err;
	err = xhc_dro_init(xhc, xhc_send_report);
	if (err)
		return err;
	err = xhc_input_init(xhc);
	if (err)
		return err;

	err = hid_hw_start(hdev, HID_CONNECT_HIDRAW);
	if (err)
		return err;
	/* autosuspend would lose the detent that wakes the device */
	err = hid_hw_power(hdev, PM_HINT_FULLON);
	if (err < 0)
		goto err_stop;
	err = hid_hw_open(hdev);
	if (err)
		goto err_power;

	/* the input device comes last: programs act on its uevent at once */
	xhc_input_start(xhc);
	hid_device_io_start(hdev);
	xhc_dro_start(xhc);
	xhc->pm_nb.notifier_call = xhc_pm_notify;
	err = register_pm_notifier(&xhc->pm_nb);
	if (err)
		goto err_io;
	err = xhc_sysfs_add(xhc);
	if (err)
		goto err_pm;
	err = xhc_input_register(xhc);
	if (err)
		goto err_sysfs;

	hid_info(hdev, "XHC %s pendant\n", xhc->model->name);
	return 0;

err_sysfs:
	xhc_sysfs_remove(xhc);
err_pm:
	unregister_pm_notifier(&xhc->pm_nb);
err_io:
	/* reports start a timer and the display's worker, so they are stopped first */
	hid_device_io_stop(hdev);
	xhc_input_stop(xhc);
	xhc_dro_stop(xhc);
	hid_hw_close(hdev);
err_power:
	hid_hw_power(hdev, PM_HINT_NORMAL);
err_stop:
	hid_hw_stop(hdev);
	return err;
}

static void xhc_remove(struct hid_device *hdev)
{
	struct xhc_device *xhc = hid_get_drvdata(hdev);

	unregister_pm_notifier(&xhc->pm_nb);
	/* no report comes while the HID core removes */
	xhc_input_stop(xhc);
	xhc_dro_stop(xhc);
	xhc_sysfs_remove(xhc);
	hid_hw_close(hdev);
	hid_hw_power(hdev, PM_HINT_NORMAL);
	hid_hw_stop(hdev);
}

static int xhc_suspend(struct hid_device *hdev, pm_message_t message)
{
	struct xhc_device *xhc = hid_get_drvdata(hdev);

	xhc_input_stop(xhc);
	xhc_dro_stop(xhc);
	return 0;
}

static int xhc_resume(struct hid_device *hdev)
{
	struct xhc_device *xhc = hid_get_drvdata(hdev);

	xhc_input_start(xhc);
	xhc_dro_start(xhc);
	return 0;
}

/*
 * Match exact products: the vendor has other devices as well. driver_data is the
 * product id of the model, so that new_id can bind a clone with another id.
 */
static const struct hid_device_id xhc_devices[] = {
	{ HID_USB_DEVICE(XHC_VENDOR_ID, XHC_PRODUCT_HB03), .driver_data = XHC_PRODUCT_HB03 },
	{ HID_USB_DEVICE(XHC_VENDOR_ID, XHC_PRODUCT_HB04), .driver_data = XHC_PRODUCT_HB04 },
	{ HID_USB_DEVICE(XHC_VENDOR_ID, XHC_PRODUCT_WHB04B), .driver_data = XHC_PRODUCT_WHB04B },
	{ }
};
MODULE_DEVICE_TABLE(hid, xhc_devices);

static struct hid_driver xhc_driver = {
	.name = "hid-xhc",
	.id_table = xhc_devices,
	.probe = xhc_probe,
	.remove = xhc_remove,
	.raw_event = xhc_raw_event,
	.suspend = pm_ptr(xhc_suspend),
	.resume = pm_ptr(xhc_resume),
	.reset_resume = pm_ptr(xhc_resume),
};
module_hid_driver(xhc_driver);

MODULE_AUTHOR("xhc-xy3 developers");
MODULE_DESCRIPTION("XHC HB03, HB04 and WHB04B pendants: jog wheel, keys, selector and display");
MODULE_LICENSE("GPL");
MODULE_VERSION("0.1.0");
