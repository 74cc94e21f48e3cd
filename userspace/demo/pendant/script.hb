# SPDX-License-Identifier: GPL-2.0-only
# Operation of an HB03 or HB04; see xhc-sim(1). These events must be reported:
# evdev: BTN_TRIGGER_HAPPY2), value 1
# evdev: BTN_TRIGGER_HAPPY31), value 1
# evdev: REL_DIAL), value -3
echo The pendant is plugged in and waits for the machine.
expect spindle_override 80
wait 300
lcd
wait 700
echo Selector to X, ten detents to the right, three to the left.
select x
wait 500
wheel 10
wait 300
wheel -3
expect work_x 0.07
wait 300
lcd
wait 700
echo Selector to Z, slowly down.
select z
wheel -1
wait 200
wheel -1
wait 200
wheel -1
expect work_z -0.03
echo Start, and pause again.
key Start/Pause press
expect state run
wait 300
lcd
wait 700
key Start/Pause press
expect state pause
wait 500
echo Without operation the pendant falls asleep, with the selector at Z.
sleep
wait 300
lcd
wait 700
echo The pendant is unplugged.
