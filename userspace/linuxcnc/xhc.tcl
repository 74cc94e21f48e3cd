# SPDX-License-Identifier: GPL-2.0-only
#
# What xhc-hb04.tcl and xhc-whb04b.tcl have in common: xhc-jog.hal and xhc-dro.hal, with what the
# machine's own files allow. A pin that is written to a signal of theirs keeps that signal, and so
# does one that reads a signal of theirs which nothing writes; an axis that the machine does not have
# is left out; before homing an axis moves its joints, if the kinematics are trivkins; halui is
# started if it does not run.

source [file join $::env(HALLIB_DIR) hal_procs_lib.tcl]

namespace eval xhc {
	variable folder [file dirname [file normalize [info script]]]
	variable letters {X Y Z A B C}
	variable signals	;# ours -> theirs
	variable joints		;# letter -> its joints
	array set signals {}
	array set joints {X {} Y {} Z {} A {} B {} C {}}
}

proc xhc::fail {text} {
	puts stderr "xhc.tcl: $text"
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

# [XHC]NAME_X of the ini, or [XHC]NAME, or nothing
proc xhc::setting {name {letter ""}} {
	foreach each [list ${name}_$letter $name] {
		if {[info exists ::XHC($each)]} {
			return [join $::XHC($each)]
		}
	}
	return ""
}

# A pin of our files -> pins of this machine
proc xhc::pins_for {pin} {
	variable joints
	variable letters
	if {[regexp {^(halui\.)?joint\.(\d+)\.(.*)} $pin all halui number name]} {
		set found {}
		foreach joint $joints([lindex $letters $number]) {
			lappend found ${halui}joint.$joint.$name
		}
		return $found
	}
	if {[regexp {^(halui\.)?axis\.[abcxyz]\.} $pin] && ![pin_exists $pin]} {
		return {}
	}
	return [list $pin]
}

proc xhc::has_writer {signal} {
	return [regexp {<==} [hal show sig $signal]]
}

proc xhc::net {signal pins} {
	variable signals
	variable smooth
	set new {}
	foreach pin $pins {
		if {[regexp {^(axis\.(.)|joint\.(\d+))\.jog-counts$} $pin all one letter number]} {
			variable letters
			if {$letter == ""} {
				set letter [lindex $letters $number]
			}
			set letter [string toupper $letter]
			if {[info exists smooth($letter)]} {
				foreach each [pins_for $pin] {
					hal net $smooth($letter) $each
				}
				continue
			}
		}
		foreach each [pins_for $pin] {
			set kind [is_connected $each theirs]
			if {$kind == "not_connected"} {
				lappend new $each
			} elseif {$kind == "is_input" && ([has_writer $theirs] ||
					[info exists signals($signal)] ||
					[lsearch -exact [hal list sig] $signal] >= 0)} {
				fail "$each is already connected to the signal $theirs"
			} else {
				set signals($signal) $theirs
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

# [XHC]NAME: a part of 1, without which an axis may swing, or never stop
proc xhc::part {name letter} {
	set value [setting $name $letter]
	if {![string is double -strict $value] || !($value > 0 && $value <= 1)} {
		fail "\[XHC\]$name is $value, but must be above 0 and up to 1"
	}
	return $value
}

# [XHC]FILTER: the gain of a filter behind the wheel; xhc-dro makes the steps shorter by its scale
proc xhc::filter {} {
	variable letters
	variable smooth
	variable thread
	array set smooth {}
	set names {}
	foreach letter $letters {
		set name xhc.smooth-[string tolower $letter]
		if {[setting FILTER $letter] != "" && [pin_exists axis.[string tolower $letter].jog-counts]} {
			lappend names $name
			set smooth($letter) xhc.counts-[string tolower $letter]
		}
	}
	if {![llength $names]} {
		return
	}
	load ilowpass [list names=[join $names ,]]
	foreach name $names {
		set letter [string toupper [string index $name end]]
		hal addf $name $thread
		hal setp $name.scale 1000
		hal setp $name.gain [part FILTER $letter]
		hal net xhc.wheel-[string index $name end] $name.in
		hal net $smooth($letter) $name.out
	}
}

# [XHC]ACCELERATION: the part of an axis' acceleration that a jog by the wheel has
proc xhc::acceleration {} {
	variable letters
	set number 0
	foreach letter $letters {
		if {[setting ACCELERATION $letter] != ""} {
			set axis axis.[string tolower $letter]
			foreach pin [concat [pins_for $axis.jog-accel-fraction] \
					[pins_for joint.$number.jog-accel-fraction]] {
				hal setp $pin [part ACCELERATION $letter]
			}
		}
		incr number
	}
}

# The greatest velocities of linear and angular axes, for the mode continuous; without one, xhc-dro
# has that of the axis
proc xhc::velocities {} {
	foreach {pin name axes} {
		max-velocity MAX_LINEAR_VELOCITY {X Y Z}
		max-angular-velocity MAX_ANGULAR_VELOCITY {A B C}
	} {
		set found ""
		# stepconf writes that of angular axes for the screen only
		foreach section {DISPLAY TRAJ} {
			if {[info exists ::${section}($name)]} {
				set found [lindex [set ::${section}($name)] 0]
				hal setp xhc-dro.$pin $found
			}
		}
		foreach letter $axes {
			# HAL has pins of axes that the machine lacks
			if {$found == "" && ![info exists ::AXIS_${letter}(MAX_VELOCITY)] &&
					[info exists ::TRAJ(COORDINATES)] &&
					[regexp -nocase $letter [join $::TRAJ(COORDINATES)]]} {
				puts stderr "xhc.tcl: in the mode continuous axis $letter does not move:\
the ini has neither \[TRAJ\]$name nor \[AXIS_$letter\]MAX_VELOCITY"
			}
		}
	}
}

proc xhc::load {component words} {
	if {[lsearch -exact [hal list comp] $component] >= 0} {
		fail "another HAL file loads $component: add these names there, and remove the line\
from your copy of xhc-jog.hal: $words"
	}
	hal loadrt $component {*}$words
}

proc xhc::run {name} {
	variable folder
	variable thread
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
			loadrt { load [lindex $words 1] [lrange $words 2 end] }
			addf { hal addf [lindex $words 1] $thread }
			default { hal {*}$words }
		}
	}
}

# `override`: what a detent or a press of a key is of the feed and the spindle
proc xhc::add {model override} {
	variable thread
	variable smooth
	if {![pin_exists halui.machine.is-on]} {
		hal loadusr -Wn halui halui -ini $::env(INI_FILE_NAME)
	}
	find_joints
	set thread [thread_info threads]
	filter
	run xhc-jog.hal
	set phys [setting PHYS]
	if {$phys != ""} {
		set phys [list --phys $phys]
	}
	set filtered {}
	if {[array size smooth]} {
		set filtered [list --filtered [string tolower [join [array names smooth] ""]]]
	}
	hal loadusr -W xhc-dro --model $model {*}$phys {*}$filtered
	velocities
	run xhc-dro.hal
	acceleration
	hal setp halui.feed-override.scale $override
	hal setp halui.spindle.0.override.scale $override
}
