# SPDX-License-Identifier: Apache-2.0
"""Drops files on a window, as a file manager does: by the protocol XDND, version 5."""
import ctypes
import ctypes.util

NOTIFIED, REQUESTED, MESSAGE = 31, 30, 33  # SelectionNotify, SelectionRequest, ClientMessage


class Message(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                ("display", ctypes.c_void_p), ("window", ctypes.c_ulong), ("message", ctypes.c_ulong),
                ("format", ctypes.c_int), ("data", ctypes.c_long * 5)]


class Request(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                ("display", ctypes.c_void_p), ("owner", ctypes.c_ulong), ("requestor", ctypes.c_ulong),
                ("selection", ctypes.c_ulong), ("target", ctypes.c_ulong), ("property", ctypes.c_ulong),
                ("time", ctypes.c_ulong)]


class Notice(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                ("display", ctypes.c_void_p), ("requestor", ctypes.c_ulong), ("selection", ctypes.c_ulong),
                ("target", ctypes.c_ulong), ("property", ctypes.c_ulong), ("time", ctypes.c_ulong)]


class Event(ctypes.Union):
    _fields_ = [("type", ctypes.c_int), ("message", Message), ("request", Request), ("notice", Notice),
                ("room", ctypes.c_long * 24)]


def drop(screen, window, files):
    """Drops `files` on the window of this number, and returns when they were taken."""
    x11 = ctypes.CDLL(ctypes.util.find_library("X11"))
    for name in "XOpenDisplay", "XInternAtom", "XCreateSimpleWindow", "XDefaultRootWindow":
        getattr(x11, name).restype = ctypes.c_ulong
    display = ctypes.c_void_p(x11.XOpenDisplay(screen.encode()))
    atom = {name: x11.XInternAtom(display, name.encode(), 0)
            for name in ("XdndEnter", "XdndPosition", "XdndDrop", "XdndFinished", "XdndSelection", "XdndActionCopy",
                         "text/uri-list")}
    root = ctypes.c_ulong(x11.XDefaultRootWindow(display))
    source = x11.XCreateSimpleWindow(display, root, 0, 0, 1, 1, 0, ctypes.c_ulong(0), ctypes.c_ulong(0))
    x11.XSetSelectionOwner(display, ctypes.c_ulong(atom["XdndSelection"]), ctypes.c_ulong(source), ctypes.c_ulong(0))

    def send(to, event):
        x11.XSendEvent(display, ctypes.c_ulong(to), 0, ctypes.c_long(0), ctypes.byref(event))
        x11.XFlush(display)

    def tell(message, *data):
        event = Event()
        event.message = Message(MESSAGE, 0, 1, display.value, window, atom[message], 32,
                                (ctypes.c_long * 5)(source, *data))
        send(window, event)

    tell("XdndEnter", 5 << 24, atom["text/uri-list"], 0, 0)
    tell("XdndPosition", 0, 600 << 16 | 300, 0, atom["XdndActionCopy"])
    tell("XdndDrop", 0, 0, 0, 0)
    names = "".join(f"file://{file}\r\n" for file in files).encode()
    event = Event()
    while not (event.type == MESSAGE and event.message.message == atom["XdndFinished"]):
        x11.XNextEvent(display, ctypes.byref(event))
        if event.type != REQUESTED:
            continue
        request = event.request
        x11.XChangeProperty(display, ctypes.c_ulong(request.requestor), ctypes.c_ulong(request.property),
                            ctypes.c_ulong(request.target), 8, 0, names, len(names))
        answer = Event()
        answer.notice = Notice(NOTIFIED, 0, 1, display.value, request.requestor, request.selection, request.target,
                               request.property, request.time)
        send(request.requestor, answer)
    x11.XCloseDisplay(display)
