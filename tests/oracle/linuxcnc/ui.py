#!/usr/bin/python3
"""What LinuxCNC starts as its screen: switches the machine on, homes it, runs run-0.ngc, run-1.ngc … and records every servo cycle.

With a file jog.txt all joints are jogged by the distance in it before homing. LinuxCNC shuts down when this ends. Leaves
cycles-0.txt … (halsampler), cycles-jog.txt and messages.txt (the operator's messages).
"""
import os
import signal
import subprocess
import sys
import time

import linuxcnc

command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
messages = open("messages.txt", "w")


def note_messages():
    while True:
        message = errors.poll()
        if not message:
            break
        print(str(message[1]).strip(), file=messages, flush=True)


def wait(what, seconds):
    end = time.time() + seconds
    while time.time() < end:
        status.poll()
        note_messages()
        if what():
            return True
        time.sleep(0.01)
    print("the screen waited %g s in vain" % seconds, file=messages, flush=True)
    return False


def begun():
    """The part program is being read, or moves already."""
    return status.interp_state != linuxcnc.INTERP_IDLE


def ended():
    """The part program is over; a halt in it (M0) is answered with cycle start at once."""
    if status.interp_state == linuxcnc.INTERP_PAUSED:
        command.auto(linuxcnc.AUTO_RESUME)
        command.wait_complete()
        return False
    return status.inpos and status.interp_state == linuxcnc.INTERP_IDLE and status.queue == 0


def recorded(name, action):
    """Every servo cycle of what is done."""
    recorder = subprocess.Popen(["halsampler", "-t"], stdout=open("cycles-%s.txt" % name, "w"))
    time.sleep(0.3)
    over = action()
    time.sleep(0.3)
    recorder.send_signal(signal.SIGINT)
    recorder.wait(10)
    return over


def run(number):
    """Leads the machine through one part program."""
    mode(linuxcnc.MODE_AUTO)
    command.program_open("run-%d.ngc" % number)
    command.wait_complete()

    def through():
        command.auto(linuxcnc.AUTO_RUN, 0)
        return wait(begun, 10) and wait(ended, 250)

    return recorded(number, through)


def jog(distance):
    """All joints by a distance, not homed."""
    joints = range(status.joints)
    for joint in joints:
        command.jog(linuxcnc.JOG_INCREMENT, True, joint, 50, distance)
    return wait(lambda: all(abs(status.joint_position[joint] - distance) < 1e-6 for joint in joints), 10)


def mode(wanted):
    command.mode(wanted)
    command.wait_complete()


command.state(linuxcnc.STATE_ESTOP_RESET)
if command.wait_complete() < 0:
    sys.exit("nothing answers: the task did not start")
command.state(linuxcnc.STATE_ON)
command.wait_complete()
mode(linuxcnc.MODE_MANUAL)
command.teleop_enable(0)
command.wait_complete()
status.poll()
if os.path.exists("jog.txt"):
    recorded("jog", lambda: jog(float(open("jog.txt").read())))
command.home(-1)
if wait(lambda: all(status.homed[: status.joints]), 30):
    number = 0
    while os.path.exists("run-%d.ngc" % number) and run(number):
        number += 1
note_messages()
