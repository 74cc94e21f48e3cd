# SPDX-License-Identifier: GPL-2.0-only
#
# An XHC HB04 for any machine: in its ini, after all other HALFILEs,
#
#	[HAL]
#	HALFILE = /usr/share/xhc-xy3/linuxcnc/xhc-hb04.tcl
#
# It runs xhc-jog.hal and xhc-dro.hal, with what the machine's own files allow: a pin that is
# written to a signal of theirs keeps that signal; an axis that the machine does not have is left
# out; before homing an axis moves its joints, if the kinematics are trivkins; halui is started if it
# does not run.

source [file join $::env(HALLIB_DIR) hal_procs_lib.tcl]

namespace eval xhc {
	variable folder [file dirname [file normalize [info script]]]
	variable letters {X Y Z A}
	variable signals	;# ours -> theirs
	variable joints		;# letter -> its joints
	array set signals {}
	array set joints {X {} Y {} Z {} A {}}
}

proc xhc::fail {text} {
	puts stderr "xhc-hb04.tcl: $text"
	exit 1
}

proc xhc::find_joints {} {
	variable joints
	set kinematics [join $::KINS(KINEMATICS)]
	if {![regexp {^trivkins} $kinematics]} {
		return
	}
	set coordinates XYZABCUVW
	regexp -nocase {coordinates=([a-z]+)} $kinematics all coordinates
	set number 0
	foreach letter [split [string toupper $coordinates] ""] {
		if {$number < [lindex $::KINS(JOINTS) 0]} {
			lappend joints($letter) $number
		}
		incr number
	}
}

# A pin of our files -> pins of this machine
proc xhc::pins_for {pin} {
	variable joints
	variable letters
	if {[regexp {^joint\.(\d+)\.(.*)} $pin all number name]} {
		set found {}
		foreach joint $joints([lindex $letters $number]) {
			lappend found joint.$joint.$name
		}
		return $found
	}
	if {[regexp {^(halui\.)?axis\.} $pin] && ![pin_exists $pin]} {
		return {}
	}
	return [list $pin]
}

proc xhc::net {signal pins} {
	variable signals
	set new {}
	foreach pin $pins {
		foreach each [pins_for $pin] {
			set kind [is_connected $each theirs]
			if {$kind == "is_output"} {
				set signals($signal) $theirs
			} elseif {$kind == "is_input"} {
				fail "$each is wired to $theirs already"
			} else {
				lappend new $each
			}
		}
	}
	if {[info exists signals($signal)]} {
		set signal $signals($signal)
	}
	if {[llength $new]} {
		hal net $signal {*}$new
	}
}

proc xhc::run {name thread} {
	variable folder
	set file [open [file join $folder $name]]
	set lines [split [read $file] "\n"]
	close $file
	foreach line $lines {
		set words [regexp -all -inline {\S+} $line]
		switch -glob -- [lindex $words 0] {
			"" - #* {}
			net {
				net [lindex $words 1] [lsearch -all -inline -not [lrange $words 2 end] =>]
			}
			loadrt {
				set component [lindex $words 1]
				if {[lsearch -exact [hal list comp] $component] >= 0} {
					fail "another file loads $component: add these names there, \
and remove the line from a copy of $name: [lrange $words 2 end]"
				}
				hal {*}$words
			}
			addf { hal addf [lindex $words 1] $thread }
			loadusr { hal {*}[string map [list xhc-input.hal [file join $folder xhc-input.hal]] $words] }
			default { hal {*}$words }
		}
	}
}

if {![pin_exists halui.machine.is-on]} {
	hal loadusr -Wn halui halui -ini $::env(INI_FILE_NAME)
}
xhc::find_joints
set xhc::thread [thread_info xhc::threads]
xhc::run xhc-jog.hal $xhc::thread
xhc::run xhc-dro.hal $xhc::thread
