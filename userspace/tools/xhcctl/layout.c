// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl layout
 */
#include <dirent.h>
#include <errno.h>
#include <json-c/json.h>
#include <stdlib.h>
#include <string.h>

#include "hwdb.h"
#include "layout.h"
#include "verbs.h"

#define DEFAULT	"default"

struct options {
	struct cli_common common;
	const char *name;
	const char *root;
	bool captions, write, apply;
};

static const struct argp_option option_table[] = {
	{ "captions", 'c', NULL, 0, "Labels only: the keys keep the codes of the driver", 0 },
	{ "write", 'w', NULL, 0, "Write the entry to " HWDB_FILE, 0 },
	{ "apply", 'a', NULL, 0, "Write the entry and activate it", 0 },
	{ "root", 'r', "FOLDER", 0, "Write below FOLDER, as systemd-hwdb --root does", 0 },
	{ 0 }
};

static const char doc[] =
	"List key layouts, or choose one."
	"\v"
	"Labels differ between pendants with the same id. A layout defines the label of each key, "
	"and the code of <linux/input-event-codes.h> that matches it. It is chosen by an entry of "
	"udev's hwdb: `layout NAME' prints the entry, --write writes it to the directory of udev, and "
	"--apply also activates it at once. `layout default' removes the entry: all keys are "
	"BTN_TRIGGER_HAPPY<code> again.\n\n"
	"With --device the entry applies only to that pendant at its current port. Files in the "
	"directory that the environment variable XHC_LAYOUTS names are layouts, too. "
	"Codes that stop the computer (KEY_RESTART, KEY_POWER, KEY_SLEEP, ...) are refused.\n\n"
	"  xhcctl layout hb04-16\n"
	"  sudo xhcctl layout hb04-16 --apply\n"
	"  sudo xhcctl layout hb04-16 --captions --apply   # labels only, codes stay\n"
	"  sudo xhcctl layout default --apply";

static error_t parse(int key, char *argument, struct argp_state *state)
{
	struct options *options = state->input;

	switch (key) {
	case ARGP_KEY_INIT:
		state->child_inputs[0] = &options->common;
		return 0;
	case 'c':
		options->captions = true;
		return 0;
	case 'w':
		options->write = true;
		return 0;
	case 'a':
		options->write = true;
		options->apply = true;
		return 0;
	case 'r':
		options->root = argument;
		return 0;
	case ARGP_KEY_ARG:
		if (options->name)
			argp_error(state, "one layout only");
		options->name = argument;
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

/* ---- list ---- */

static int is_layout(const struct dirent *entry)
{
	size_t length = strlen(entry->d_name), suffix = strlen(LAYOUT_SUFFIX);

	return length > suffix && !strcmp(entry->d_name + length - suffix, LAYOUT_SUFFIX);
}

static size_t count_keys(const struct layout *layout)
{
	size_t count = 0;

	for (unsigned int scan = 1; scan <= LAYOUT_KEYS; scan++)
		count += *layout->key[scan].caption != '\0';
	return count;
}

static void add_layout(struct json_object *array, const struct layout *layout)
{
	struct json_object *object = json_object_new_object();

	cli_json_text(object, "name", layout->name);
	cli_json_text(object, "title", layout->title);
	cli_json_number(object, "keys", count_keys(layout));
	cli_json_text(object, "match", layout->match);
	json_object_array_add(array, object);
}

static bool listed(struct json_object *array, const char *name)
{
	for (size_t i = 0; i < json_object_array_length(array); i++) {
		struct json_object *member;

		if (json_object_object_get_ex(json_object_array_get_idx(array, i), "name",
					      &member) &&
		    !strcmp(json_object_get_string(member), name))
			return true;
	}
	return false;
}

static int add_folder(struct json_object *array, const char *folder)
{
	int status = CLI_OK, count;
	struct dirent **entries;

	count = scandir(folder, &entries, is_layout, alphasort);
	if (count < 0)
		return errno == ENOENT ? CLI_OK : cli_errno(errno, "%s", folder);
	for (int i = 0; i < count; i++) {
		char *name = entries[i]->d_name;
		struct layout layout;

		name[strlen(name) - strlen(LAYOUT_SUFFIX)] = '\0';
		if (!listed(array, name)) {
			int one = layout_read(name, &layout);

			if (one == CLI_OK)
				add_layout(array, &layout);
			else
				status = CLI_FAILURE;
		}
		free(entries[i]);
	}
	free(entries);
	return status;
}

static const char *member_text(struct json_object *object, const char *key)
{
	struct json_object *member = NULL;

	json_object_object_get_ex(object, key, &member);
	return json_object_get_string(member);
}

static void print_list(struct json_object *array)
{
	printf("%s%-12s %-4s %-32s %s%s\n", cli_colour(CLI_BOLD), "NAME", "KEYS", "FOR", "TITLE",
	       cli_colour(CLI_PLAIN));
	for (size_t i = 0; i < json_object_array_length(array); i++) {
		struct json_object *object = json_object_array_get_idx(array, i);

		printf("%-12s %-4s %-32s %s\n", member_text(object, "name"),
		       member_text(object, "keys"), member_text(object, "match"),
		       member_text(object, "title"));
	}
}

static int list_layouts(const struct options *options)
{
	struct json_object *document, *array = json_object_new_array();
	int status = CLI_OK;

	for (const char *const *folder = layout_folders(); *folder; folder++)
		status = add_folder(array, *folder) ?: status;
	if (!json_object_array_length(array) && status == CLI_OK)
		status = cli_error("no layouts in %s", DATADIR "/layouts");
	if (!options->common.json) {
		print_list(array);
		json_object_put(array);
		return status;
	}
	document = cli_json_new("layout");
	json_object_object_add(document, "layouts", array);
	return cli_json_print(document) ?: status;
}

/* ---- one layout ---- */

static int print_one(const struct layout *layout, const char *entry, const struct options *options)
{
	struct json_object *document, *keys;

	if (!options->common.json) {
		fputs(entry, stdout);
		return CLI_OK;
	}
	document = cli_json_new("layout");
	keys = json_object_new_array();
	cli_json_text(document, "name", layout->name);
	cli_json_text(document, "title", layout->title);
	cli_json_text(document, "entry", entry);
	for (unsigned int scan = 1; scan <= LAYOUT_KEYS; scan++) {
		const struct layout_key *key = &layout->key[scan];
		struct json_object *object;

		if (!*key->caption)
			continue;
		object = json_object_new_object();
		cli_json_number(object, "scan", scan);
		cli_json_text(object, "caption", key->caption);
		cli_json_text(object, "code", *key->code ? key->code : NULL);
		cli_json_text(object, "fn", *key->fn ? key->fn : NULL);
		json_object_array_add(keys, object);
	}
	json_object_object_add(document, "keys", keys);
	return cli_json_print(document);
}

static int use_entry(const char *entry, const struct options *options)
{
	char *path = hwdb_path(options->root);
	int status;

	if (!path)
		return cli_errno(ENOMEM, "%s", HWDB_FILE);
	status = entry ? hwdb_write(path, entry) : hwdb_remove(path);
	if (status == CLI_OK && options->apply)
		status = hwdb_apply();
	else if (status == CLI_OK)
		hwdb_say(options->root);
	if (status == CLI_OK && !options->apply && (!entry || options->captions))
		fprintf(stderr, "Keys have their initial codes again the next time that the "
			"pendant is plugged in.\n");
	free(path);
	return status;
}

static int choose_layout(const struct options *options)
{
	struct pendant pendant;
	struct layout layout;
	size_t size = 0;
	char *entry = NULL;
	FILE *stream;
	int status;

	status = layout_read(options->name, &layout);
	if (status == CLI_OK && options->common.device)
		status = pendant_choose(options->common.device, &pendant);
	if (status != CLI_OK)
		return status;
	stream = open_memstream(&entry, &size);
	if (!stream)
		return cli_errno(errno, "%s", layout.name);
	layout_entry(stream, &layout, options->common.device ? &pendant : NULL,
		     options->captions);
	fclose(stream);
	status = options->write ? use_entry(entry, options) :
				  print_one(&layout, entry, options);
	free(entry);
	return status;
}

int layout_verb(int argc, char **argv)
{
	const struct argp argp = {
		.options = option_table, .parser = parse, .args_doc = "[list|NAME|" DEFAULT "]",
		.doc = doc, .children = cli_children,
	};
	struct options options = { 0 };
	bool list;

	argp_parse(&argp, argc, argv, 0, NULL, &options);
	list = !options.name || !strcmp(options.name, "list");
	if (list && (options.write || options.captions || options.common.device))
		return cli_usage("list takes no such option");
	if (options.root && (options.apply || !options.write))
		return cli_usage("--root requires --write, and excludes --apply");
	if (options.write && options.common.json)
		return cli_usage("--json cannot be combined with --write or --apply");
	if (list)
		return list_layouts(&options);
	if (!strcmp(options.name, DEFAULT)) {
		if (!options.write || options.captions || options.common.device)
			return cli_usage(DEFAULT " has no entry; use --write or --apply to remove "
					 "an existing one");
		return use_entry(NULL, &options);
	}
	return choose_layout(&options);
}
