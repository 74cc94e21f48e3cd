// SPDX-License-Identifier: GPL-2.0-only
/*
 * Advice that depends on the distribution. If no command is known for it, it is text.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "doctor.h"

enum family { OTHER, DEBIAN, UBUNTU, FEDORA, ARCH };

/* A variable of os-release, without quotes; "" if it does not exist */
static void read_variable(struct doctor *doctor, const char *variable, char *value, size_t size)
{
	char text[4096];
	size_t length = strlen(variable);

	value[0] = '\0';
	if (doctor_read(doctor, text, sizeof(text), "/etc/os-release") < 0)
		doctor_read(doctor, text, sizeof(text), "/usr/lib/os-release");
	for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
		if (strncmp(line, variable, length) || line[length] != '=')
			continue;
		line += length + 1;
		line += *line == '"';
		snprintf(value, size, "%.*s", (int)strcspn(line, "\""), line);
	}
}

static enum family find_family(struct doctor *doctor)
{
	static const struct {
		const char *name;
		enum family family;
	} names[] = {
		/* Derivatives of Ubuntu are like Debian, too */
		{ "ubuntu", UBUNTU }, { "debian", DEBIAN }, { "raspbian", DEBIAN },
		{ "fedora", FEDORA }, { "rhel", FEDORA }, { "arch", ARCH },
	};
	char id[64], like[128], words[256];

	read_variable(doctor, "ID", id, sizeof(id));
	read_variable(doctor, "ID_LIKE", like, sizeof(like));
	snprintf(words, sizeof(words), " %s %s ", id, like);
	for (size_t i = 0; i < ARRAY_SIZE(names); i++) {
		char word[32];

		snprintf(word, sizeof(word), " %s ", names[i].name);
		if (strstr(words, word))
			return names[i].family;
	}
	return OTHER;
}

bool doctor_is_image(struct doctor *doctor)
{
	char id[64];

	read_variable(doctor, "ID", id, sizeof(id));
	return doctor_exists(doctor, "/run/ostree-booted") || !strcmp(id, "steamos");
}

/* The class in the header of an ELF file: 32 or 64; 0 if it is not an ELF file */
static int elf_bits(struct doctor *doctor, const char *path)
{
	char header[6];

	if (doctor_read(doctor, header, sizeof(header), path) < 5 || memcmp(header, "\177ELF", 4))
		return 0;
	return header[4] == 1 ? 32 : 64;
}

static bool kernel_is_64_bit(struct doctor *doctor)
{
	char arch[32];

	doctor_read(doctor, arch, sizeof(arch), "/proc/sys/kernel/arch");	/* since 6.1 */
	return strstr(arch, "64") || strstr(doctor_kernel(doctor), "-v8");
}

/* Six digits repeat the version: 6.17.8-061708-generic */
static bool is_ubuntu_mainline(const char *kernel)
{
	const char *dash = strchr(kernel, '-');

	return dash && strspn(dash + 1, "0123456789") >= 6;
}

/* The database of dpkg is private. A package of a kernel has a separate directory. */
static bool is_package(struct doctor *doctor, const char *kernel)
{
	static const char *const names[] = {
		"doc/linux-image", "doc/linux-image-unsigned", "doc/linux-modules",
		"bug/linux-image",	/* a file of Debian, if documentation is not installed */
	};
	char path[256];

	for (size_t i = 0; i < ARRAY_SIZE(names); i++) {
		snprintf(path, sizeof(path), "/usr/share/%s-%s", names[i], kernel);
		if (doctor_exists(doctor, path))
			return true;
	}
	return false;
}

static void apt_headers(struct doctor *doctor, char *fix, size_t size)
{
	const char *kernel = doctor_kernel(doctor);

	if (is_ubuntu_mainline(kernel))
		snprintf(fix, size, "install the linux-headers packages of the same mainline "
			 "build, from where the kernel came");
	else if (is_package(doctor, kernel))
		snprintf(fix, size, "sudo apt install linux-headers-%s", kernel);
	else
		snprintf(fix, size, "no package has this kernel: install the headers that were "
			 "built with it, or start a kernel of the distribution");
}

/* The package of a kernel has a file with its name beside the modules */
static void pacman_headers(struct doctor *doctor, char *fix, size_t size)
{
	char path[256], name[64];

	snprintf(path, sizeof(path), "/lib/modules/%s/pkgbase", doctor_kernel(doctor));
	if (doctor_read(doctor, name, sizeof(name), path) > 0)
		snprintf(fix, size, "sudo pacman -S %s-headers", name);
	else
		snprintf(fix, size, "install the headers that belong to this kernel");
}

void doctor_headers_fix(struct doctor *doctor, char *fix, size_t size)
{
	const char *kernel = doctor_kernel(doctor);
	enum family family = find_family(doctor);
	char path[256];

	snprintf(path, sizeof(path), "/lib/modules/%s", kernel);
	if (doctor_is_image(doctor))
		snprintf(fix, size, DOCTOR_IMAGE);
	else if (!doctor_exists(doctor, path))
		snprintf(fix, size, "restart the computer: the running kernel is no longer "
			 "installed");
	else if (kernel_is_64_bit(doctor) && elf_bits(doctor, "/bin/sh") == 32)
		snprintf(fix, size, "the kernel has 64 bits, and the system 32: use a 64-bit "
			 "system, or, on a Raspberry Pi, write arm_64bit=0 to config.txt and restart");
	else if (family == DEBIAN || family == UBUNTU)
		apt_headers(doctor, fix, size);
	else if (family == FEDORA && (strstr(kernel, ".fc") || strstr(kernel, ".el")))
		snprintf(fix, size, "sudo dnf install kernel-devel-%s", kernel);
	else if (family == ARCH)
		pacman_headers(doctor, fix, size);
	else
		snprintf(fix, size, "install the headers that belong to this kernel");
}

const char *doctor_key(struct doctor *doctor)
{
	return find_family(doctor) == UBUNTU ? "/var/lib/shim-signed/mok/MOK.der" :
					       "/var/lib/dkms/mok.pub";
}

void doctor_package_fix(struct doctor *doctor, const char *verb, const char *package, char *fix,
			size_t size)
{
	static const char *const commands[] = {
		[DEBIAN] = "apt", [UBUNTU] = "apt", [FEDORA] = "dnf", [ARCH] = NULL,
	};
	enum family family = find_family(doctor);

	if (doctor_is_image(doctor) || !commands[family])
		snprintf(fix, size, "%s %s", verb, package);
	else
		snprintf(fix, size, "sudo %s %s %s", commands[family], verb, package);
}
