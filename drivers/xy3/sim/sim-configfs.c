// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: heads by configfs
 *
 * A folder is a head. The module parameters are its default settings, which cannot be changed while
 * it is live.
 */

#include <linux/cleanup.h>
#include <linux/configfs.h>
#include <linux/err.h>
#include <linux/kstrtox.h>
#include <linux/module.h>
#include <linux/mutex.h>
#include <linux/platform_device.h>
#include <linux/slab.h>

#include "sim.h"

/**
 * struct sim_group - a folder
 * @group: its group of configfs
 * @number: of its head
 * @lock: protects the following members
 * @config: the settings
 * @pdev: the device of the head while it is live, or NULL
 */
struct sim_group {
	struct config_group group;
	unsigned int number;
	struct mutex lock;	/* see above */
	struct xy3_sim_config config;
	struct platform_device *pdev;
};

static struct sim_group *to_sim_group(struct config_item *item)
{
	return container_of(to_config_group(item), struct sim_group, group);
}

/* ---- files ---- */

/**
 * xy3_sim_configfs_show() - read a setting
 * @item: the folder of the head
 * @setting: the setting
 * @page: the destination
 *
 * Return: the length.
 */
ssize_t xy3_sim_configfs_show(struct config_item *item, const struct xy3_sim_setting *setting,
			      char *page)
{
	struct sim_group *group = to_sim_group(item);

	guard(mutex)(&group->lock);
	return xy3_sim_setting_print(setting, &group->config, page);
}

/**
 * xy3_sim_configfs_store() - change a setting
 * @item: the folder of the head
 * @setting: the setting
 * @page: the new value
 * @count: its length
 *
 * Return: @count; -EBUSY if the head is live; or another error.
 */
ssize_t xy3_sim_configfs_store(struct config_item *item, const struct xy3_sim_setting *setting,
			       const char *page, size_t count)
{
	struct sim_group *group = to_sim_group(item);

	guard(mutex)(&group->lock);
	if (group->pdev)
		return -EBUSY;
	return xy3_sim_setting_parse(setting, &group->config, page) ?: count;
}

/**
 * xy3_sim_number_show() - read the number of a head
 * @item: the folder of the head
 * @page: the destination
 *
 * Return: the length.
 */
ssize_t xy3_sim_number_show(struct config_item *item, char *page)
{
	return sprintf(page, "%u\n", to_sim_group(item)->number);
}

/**
 * xy3_sim_live_show() - read whether a head is live
 * @item: the folder of the head
 * @page: the destination
 *
 * Return: the length.
 */
ssize_t xy3_sim_live_show(struct config_item *item, char *page)
{
	struct sim_group *group = to_sim_group(item);

	guard(mutex)(&group->lock);
	return sprintf(page, "%d\n", !!group->pdev);
}

static int sim_start(struct sim_group *group)
{
	struct platform_device *pdev;

	if (group->pdev)
		return -EBUSY;
	pdev = xy3_sim_add(&group->config, group->number);
	if (IS_ERR(pdev))
		return PTR_ERR(pdev);
	group->pdev = pdev;
	return 0;
}

static void sim_stop(struct sim_group *group)
{
	if (group->pdev)
		xy3_sim_remove(group->pdev);
	group->pdev = NULL;
}

/**
 * xy3_sim_live_store() - create or remove a head
 * @item: the folder of the head
 * @page: whether it shall exist
 * @count: length of the text
 *
 * Return: @count or an error.
 */
ssize_t xy3_sim_live_store(struct config_item *item, const char *page, size_t count)
{
	struct sim_group *group = to_sim_group(item);
	bool live;
	int err;

	err = kstrtobool(page, &live);
	if (err)
		return err;
	guard(mutex)(&group->lock);
	if (live)
		err = sim_start(group);
	else
		sim_stop(group);
	return err ?: count;
}

/* ---- folders ---- */

static void sim_group_release(struct config_item *item)
{
	struct sim_group *group = to_sim_group(item);

	sim_stop(group);
	xy3_sim_free_number(group->number);
	mutex_destroy(&group->lock);
	kfree(group);
}

static struct configfs_item_operations sim_group_operations = {
	.release = sim_group_release,
};

static const struct config_item_type sim_group_type = {
	.ct_item_ops = &sim_group_operations,
	.ct_attrs = xy3_sim_config_attrs,
	.ct_owner = THIS_MODULE,
};

static struct config_group *sim_make_group(struct config_group *parent, const char *name)
{
	struct sim_group *group;
	int number;

	group = kzalloc(sizeof(*group), GFP_KERNEL);
	if (!group)
		return ERR_PTR(-ENOMEM);
	number = xy3_sim_new_number();
	if (number < 0) {
		kfree(group);
		return ERR_PTR(number);
	}
	group->number = number;
	group->config = xy3_sim_defaults;
	mutex_init(&group->lock);
	config_group_init_type_name(&group->group, name, &sim_group_type);
	return &group->group;
}

static struct configfs_group_operations sim_subsystem_operations = {
	.make_group = sim_make_group,
};

static const struct config_item_type sim_subsystem_type = {
	.ct_group_ops = &sim_subsystem_operations,
	.ct_owner = THIS_MODULE,
};

static struct configfs_subsystem sim_subsystem = {
	.su_group = {
		.cg_item = {
			.ci_namebuf = "xy3-sim",
			.ci_type = &sim_subsystem_type,
		},
	},
};

/**
 * xy3_sim_configfs_init() - create the folder of all heads
 *
 * Return: 0 or an error.
 */
int __init xy3_sim_configfs_init(void)
{
	config_group_init(&sim_subsystem.su_group);
	mutex_init(&sim_subsystem.su_mutex);
	return configfs_register_subsystem(&sim_subsystem);
}

/**
 * xy3_sim_configfs_exit() - remove the folder, which has no heads any more
 */
void xy3_sim_configfs_exit(void)
{
	configfs_unregister_subsystem(&sim_subsystem);
}
