// SPDX-License-Identifier: GPL-2.0-only
/*
 * Attributes of sysfs. See sysfs.h.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sysfs.h"

static int open_path(int flags, const char *format, va_list arguments)
{
	char *path;
	int fd;

	if (vasprintf(&path, format, arguments) < 0)
		return -ENOMEM;
	fd = open(path, flags | O_CLOEXEC);
	if (fd < 0)
		fd = -errno;
	free(path);
	return fd;
}

static int read_open(int fd, char *text, size_t size)
{
	ssize_t length = read(fd, text, size - 1);

	if (length < 0)
		length = -errno;
	close(fd);
	if (length < 0)
		return length;
	if (length > 0 && text[length - 1] == '\n')
		length--;
	text[length] = '\0';
	return length;
}

int sysfs_read(char *text, size_t size, const char *path, ...)
{
	va_list arguments;
	int fd;

	va_start(arguments, path);
	fd = open_path(O_RDONLY, path, arguments);
	va_end(arguments);
	return fd < 0 ? fd : read_open(fd, text, size);
}

int sysfs_read_number(long long *number, const char *path, ...)
{
	char text[32], *end;
	va_list arguments;
	int fd, length;

	va_start(arguments, path);
	fd = open_path(O_RDONLY, path, arguments);
	va_end(arguments);
	if (fd < 0)
		return fd;
	length = read_open(fd, text, sizeof(text));
	if (length < 0)
		return length;
	errno = 0;
	*number = strtoll(text, &end, 0);
	return errno || end == text || *end ? -EINVAL : 0;
}

int sysfs_write(const char *text, const char *path, ...)
{
	size_t size = strlen(text);
	va_list arguments;
	int fd, status = 0;
	ssize_t written;

	va_start(arguments, path);
	fd = open_path(O_WRONLY, path, arguments);
	va_end(arguments);
	if (fd < 0)
		return fd;
	written = write(fd, text, size);
	if (written < 0)
		status = -errno;
	else if ((size_t)written != size)
		status = -EIO;
	close(fd);
	return status;
}
