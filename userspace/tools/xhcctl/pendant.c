// SPDX-License-Identifier: GPL-2.0-only
/*
 * Find pendants. See pendant.h.
 */
#include <errno.h>
#include <libudev.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "model.h"
#include "pendant.h"
#include "sysfs.h"

#define DRIVER "hid-xhc"

static void copy(char *to, size_t size, const char *from)
{
	snprintf(to, size, "%s", from ?: "");
}

/* A child of the HID device in this subsystem that has a node with this prefix */
static struct udev_device *find_node(struct udev *udev, struct udev_device *parent,
				     const char *subsystem, const char *prefix)
{
	struct udev_enumerate *children = udev_enumerate_new(udev);
	struct udev_device *found = NULL;
	struct udev_list_entry *entry;

	udev_enumerate_add_match_parent(children, parent);
	udev_enumerate_add_match_subsystem(children, subsystem);
	udev_enumerate_scan_devices(children);
	udev_list_entry_foreach(entry, udev_enumerate_get_list_entry(children)) {
		struct udev_device *child;

		child = udev_device_new_from_syspath(udev, udev_list_entry_get_name(entry));
		if (child && udev_device_get_devnode(child) &&
		    !strncmp(udev_device_get_sysname(child), prefix, strlen(prefix))) {
			found = child;
			break;
		}
		udev_device_unref(child);
	}
	udev_enumerate_unref(children);
	return found;
}

static void look_at_nodes(struct udev *udev, struct udev_device *hid, struct pendant *pendant)
{
	struct udev_device *node;

	node = find_node(udev, hid, "input", "event");
	if (node) {
		struct udev_device *input = udev_device_get_parent(node);

		copy(pendant->event, sizeof(pendant->event), udev_device_get_devnode(node));
		copy(pendant->layout, sizeof(pendant->layout),
		     udev_device_get_property_value(node, "XHC_LAYOUT"));
		if (input)
			copy(pendant->input, sizeof(pendant->input),
			     udev_device_get_sysattr_value(input, "name"));
		udev_device_unref(node);
	}
	node = find_node(udev, hid, "hidraw", "hidraw");
	if (node) {
		copy(pendant->hidraw, sizeof(pendant->hidraw), udev_device_get_devnode(node));
		udev_device_unref(node);
	}
}

/* Return false if it is removed in the meantime. */
static bool look_at(struct udev *udev, const char *path, struct pendant *pendant)
{
	struct udev_device *hid = udev_device_new_from_syspath(udev, path);
	long long awake = 0;
	bool here;

	if (!hid)
		return false;
	copy(pendant->name, sizeof(pendant->name), udev_device_get_sysname(hid));
	copy(pendant->path, sizeof(pendant->path), udev_device_get_syspath(hid));
	copy(pendant->phys, sizeof(pendant->phys),
	     udev_device_get_property_value(hid, "HID_PHYS"));
	here = !strcmp(udev_device_get_driver(hid) ?: "", DRIVER) &&
	       sysfs_read(pendant->model, sizeof(pendant->model), "%s/model", path) > 0;
	if (here) {
		pendant->model_row = model_find(pendant->model);
		sysfs_read_number(&awake, "%s/awake", path);
		pendant->awake = awake;
		look_at_nodes(udev, hid, pendant);
	}
	udev_device_unref(hid);
	return here;
}

static int add(struct pendants *list, const struct pendant *pendant)
{
	struct pendant *item;

	item = realloc(list->item, (list->count + 1) * sizeof(*item));
	if (!item)
		return -ENOMEM;
	list->item = item;
	item[list->count++] = *pendant;
	return 0;
}

/* Numbers after the dot are assigned in the order of plugging in */
static int compare(const void *one, const void *two)
{
	const struct pendant *a = one, *b = two;
	const char *left = strrchr(a->name, '.'), *right = strrchr(b->name, '.');
	unsigned long x = left ? strtoul(left + 1, NULL, 16) : 0;
	unsigned long y = right ? strtoul(right + 1, NULL, 16) : 0;

	return (x > y) - (x < y);
}

int pendants_find(struct pendants *list)
{
	struct udev_enumerate *devices;
	struct udev_list_entry *entry;
	struct udev *udev = udev_new();
	int err = 0;

	*list = (struct pendants){ 0 };
	if (!udev)
		return -ENOMEM;
	devices = udev_enumerate_new(udev);
	udev_enumerate_add_match_subsystem(devices, "hid");
	udev_enumerate_scan_devices(devices);
	udev_list_entry_foreach(entry, udev_enumerate_get_list_entry(devices)) {
		struct pendant pendant = { 0 };

		if (!err && look_at(udev, udev_list_entry_get_name(entry), &pendant))
			err = add(list, &pendant);
	}
	udev_enumerate_unref(devices);
	udev_unref(udev);
	if (list->count)
		qsort(list->item, list->count, sizeof(*list->item), compare);
	for (size_t i = 0; i < list->count; i++)
		list->item[i].index = i;
	return err;
}

void pendants_free(struct pendants *list)
{
	free(list->item);
	*list = (struct pendants){ 0 };
}

static bool is_node(const char *node, const char *name)
{
	const char *last = strrchr(node, '/');
	char path[PATH_MAX];

	if (!*node)
		return false;
	if (!strcmp(node, name) || (last && !strcmp(last + 1, name)))
		return true;
	/* a link created by udev */
	return name[0] == '/' && realpath(name, path) && !strcmp(path, node);
}

static bool is_called(const struct pendant *pendant, const char *name)
{
	char number[16];

	snprintf(number, sizeof(number), "%u", pendant->index);
	return !strcmp(name, number) || !strcasecmp(name, pendant->name) ||
	       !strcmp(name, pendant->phys) || is_node(pendant->event, name) ||
	       is_node(pendant->hidraw, name);
}

int pendants_choose(const struct pendants *list, const char *name, struct pendant *pendant)
{
	if (!list->count)
		return cli_no_device("no pendant is plugged in, or hid-xhc does not drive it");
	if (!name && list->count > 1)
		return cli_usage("there are %zu pendants: choose one of `%s list' with --device",
				 list->count, cli_tool_name());
	if (!name) {
		*pendant = list->item[0];
		return CLI_OK;
	}
	for (size_t i = 0; i < list->count; i++) {
		if (is_called(&list->item[i], name)) {
			*pendant = list->item[i];
			return CLI_OK;
		}
	}
	return cli_no_device("no pendant %s", name);
}

int pendant_choose(const char *name, struct pendant *pendant)
{
	struct pendants list;
	int status, err;

	err = pendants_find(&list);
	status = err ? cli_errno(err, "pendants") : pendants_choose(&list, name, pendant);
	pendants_free(&list);
	return status;
}

bool pendant_present(const struct pendant *pendant)
{
	char path[sizeof(pendant->path) + 16];

	snprintf(path, sizeof(path), "%s/model", pendant->path);
	return !access(path, F_OK);
}
