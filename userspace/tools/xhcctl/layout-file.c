// SPDX-License-Identifier: GPL-2.0-only
/*
 * Files of key layouts, and the entry of udev's hwdb that is made from one. See layout.h.
 */
#include <ctype.h>
#include <errno.h>
#include <libevdev/libevdev.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "layout.h"
#include "model.h"

/*
 * Codes that systemd-logind, acpid, the power daemon of a desktop or the kernel act on. A pendant
 * is used while a machine works: none of its keys may stop the computer or lock the session.
 */
static const struct {
	int code;
	const char *reason;
} refused[] = {
	{ KEY_POWER, "KEY_POWER would switch the computer off" },
	{ KEY_POWER2, "KEY_POWER2 would switch the computer off" },
	{ KEY_RESTART, "KEY_RESTART would restart the computer" },
	{ KEY_SLEEP, "KEY_SLEEP would suspend the computer" },
	{ KEY_SUSPEND, "KEY_SUSPEND would suspend the computer to disk" },
	{ KEY_LOGOFF, "KEY_LOGOFF would end the user's session" },
	{ KEY_COFFEE, "KEY_COFFEE would lock the screen" },
	{ KEY_SYSRQ, "KEY_SYSRQ gives commands to the kernel" },
};

const char *const *layout_folders(void)
{
	static const char *folders[3];
	size_t count = 0;

	if (getenv("XHC_LAYOUTS"))
		folders[count++] = getenv("XHC_LAYOUTS");
	folders[count++] = DATADIR "/layouts";
	folders[count] = NULL;
	return folders;
}

bool layout_name_ok(const char *name)
{
	if (!isalnum((unsigned char)*name) || strlen(name) >= sizeof(((struct layout *)0)->name))
		return false;
	for (; *name; name++) {
		if (!isalnum((unsigned char)*name) && !strchr("._+-", *name))
			return false;
	}
	return true;
}

static bool printable(const char *text)
{
	for (; *text; text++) {
		if (*text < 0x20 || *text > 0x7e)
			return false;
	}
	return true;
}

/* Return false if it is empty, too long or not ASCII. */
static bool take(char *to, size_t size, const char *from)
{
	if (!*from || strlen(from) >= size || !printable(from))
		return false;
	memcpy(to, from, strlen(from) + 1);
	return true;
}

/* The scan code of a key. Return an error message, or NULL. */
static const char *take_code(const char *text, unsigned int *code)
{
	char *end;

	*code = strtoul(text, &end, 16);
	if (strlen(text) != 2 || *end || !isxdigit((unsigned char)text[0]))
		return "a key's code has two hexadecimal digits";
	if (!*code || *code > LAYOUT_KEYS)
		return "keys have the codes 01 to 17";
	return NULL;
}

static const char *take_key(struct layout *layout, char *const *field, unsigned int *last)
{
	const char *wrong;
	struct layout_key *key;
	unsigned int code;
	int event_code;

	wrong = take_code(field[0], &code);
	if (wrong)
		return wrong;
	if (code <= *last)
		return "codes must ascend";
	*last = code;
	key = &layout->key[code];
	if (!take(key->caption, sizeof(key->caption), field[1]))
		return "a caption is 1 to 31 ASCII characters";
	if (field[3] && !layout->fn)
		return "a caption with Fn requires a line with fn before it";
	if (field[3] && !take(key->fn, sizeof(key->fn), field[3]))
		return "a caption with Fn is 1 to 31 ASCII characters";
	if (!strcmp(field[2], "-"))
		return NULL;
	event_code = take(key->code, sizeof(key->code), field[2]) ?
		     libevdev_event_code_from_name(EV_KEY, key->code) : -1;
	if (event_code < 0)
		return "no such code in <linux/input-event-codes.h>";
	for (size_t i = 0; i < ARRAY_SIZE(refused); i++) {
		if (event_code == refused[i].code)
			return refused[i].reason;
	}
	return NULL;
}

/* Return an error message for a line, or NULL. last: the code of the key before. */
static const char *take_line(struct layout *layout, char *line, unsigned int *last)
{
	char *field[4] = { 0 };
	size_t count = 0;

	for (char *rest = line; rest; count++) {
		if (count == ARRAY_SIZE(field))
			return "more than four fields";
		field[count] = strsep(&rest, "\t");
	}
	if (!strcmp(field[0], "title"))
		return count == 2 && take(layout->title, sizeof(layout->title), field[1]) ?
		       NULL : "title and a text are required";
	if (!strcmp(field[0], "match"))
		return count == 2 && take(layout->match, sizeof(layout->match), field[1]) ?
		       NULL : "match and a pattern are required";
	if (!strcmp(field[0], "fn"))
		return count == 2 && !*last ? take_code(field[1], &layout->fn) :
		       "fn and a code are required, before the keys";
	if (count < 3)
		return "a code, a caption and a key's name or - are required";
	if (!*layout->title || !*layout->match)
		return "title and match come first";
	return take_key(layout, field, last);
}

/* Editors of other systems end lines with \r\n, and start a file with a byte order mark. */
static char *trim(char *line, bool first)
{
	size_t length = strcspn(line, "\n");

	if (length && line[length - 1] == '\r')
		length--;
	line[length] = '\0';
	return first && !strncmp(line, "\xef\xbb\xbf", 3) ? line + 3 : line;
}

static int read_stream(FILE *stream, const char *path, struct layout *layout)
{
	unsigned int number = 0, last = 0;
	const char *wrong = NULL;
	char line[256], *text;

	while (!wrong && fgets(line, sizeof(line), stream)) {
		number++;
		if (strlen(line) == sizeof(line) - 1)
			wrong = "the line is too long";
		text = trim(line, number == 1);
		if (!wrong && text[0] != '#')
			wrong = take_line(layout, text, &last);
	}
	if (wrong)
		return cli_error("%s:%u: %s", path, number, wrong);
	if (ferror(stream))
		return cli_errno(errno, "%s", path);
	if (!last)
		return cli_error("%s: no keys", path);
	return CLI_OK;
}

int layout_read(const char *name, struct layout *layout)
{
	*layout = (struct layout){ 0 };
	if (!layout_name_ok(name))
		return cli_usage("no layout \"%s\"", name);
	memcpy(layout->name, name, strlen(name) + 1);
	for (const char *const *folder = layout_folders(); *folder; folder++) {
		char path[PATH_MAX];
		FILE *stream;
		int status;

		snprintf(path, sizeof(path), "%s/%s" LAYOUT_SUFFIX, *folder, name);
		stream = fopen(path, "re");
		if (!stream && (errno == ENOENT || errno == ENOTDIR))
			continue;
		if (!stream)
			return cli_errno(errno, "%s", path);
		status = read_stream(stream, path, layout);
		fclose(stream);
		return status;
	}
	return cli_usage("no layout \"%s\", see `%s layout list'", name, cli_tool_name());
}

const char *layout_name(const struct pendant *pendant)
{
	return *pendant->layout ? pendant->layout : pendant->model_row->layout;
}

const char *layout_caption(const struct layout *layout, unsigned int scan, bool fn)
{
	if (scan > LAYOUT_KEYS || !*layout->key[scan].caption)
		return NULL;
	if (fn && *layout->key[scan].fn)
		return layout->key[scan].fn;
	return layout->key[scan].caption;
}

/* The name in udev: in lower case, without KEY_ */
static void print_code(FILE *stream, unsigned int scan, const char *code)
{
	fprintf(stream, " KEYBOARD_KEY_%02x=", scan);
	if (!*code)
		fprintf(stream, "btn_trigger_happy%u", scan);
	if (!strncmp(code, "KEY_", 4))
		code += 4;
	for (; *code; code++)
		fputc(tolower((unsigned char)*code), stream);
}

void layout_entry(FILE *stream, const struct layout *layout, const struct pendant *pendant,
		  bool captions)
{
	fprintf(stream, "# Key layout %s (%s), by %s layout\n", layout->name, layout->title,
		cli_tool_name());
	if (pendant)
		fprintf(stream, "evdev:name:%s:phys:%s:*\n", pendant->input, pendant->phys);
	else
		fprintf(stream, "%s\n", layout->match);
	fprintf(stream, " XHC_LAYOUT=%s\n", layout->name);
	/*
	 * All keys, also those that keep their code: otherwise keys would keep the codes of another
	 * layout.
	 */
	for (unsigned int scan = 1; scan <= LAYOUT_KEYS; scan++) {
		const char *caption = layout_caption(layout, scan, false) ?: "(no such key)";
		const char *fn = layout->key[scan].fn;

		if (captions) {
			fprintf(stream, "# %02x: %s", scan, caption);
		} else {
			print_code(stream, scan, layout->key[scan].code);
			fprintf(stream, " # %s", caption);
		}
		fprintf(stream, *fn ? "; with Fn: %s\n" : "\n", fn);
	}
}
