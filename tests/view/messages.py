# SPDX-License-Identifier: Apache-2.0
"""Messages to a window of X11: what file managers and window managers send."""
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


class Sender:
    """Sends messages to the window of this number."""

    def __init__(self, screen, window):
        self.x11 = ctypes.CDLL(ctypes.util.find_library("X11"))
        for name in "XOpenDisplay", "XInternAtom", "XCreateSimpleWindow", "XDefaultRootWindow":
            getattr(self.x11, name).restype = ctypes.c_ulong
        self.display, self.window = ctypes.c_void_p(self.x11.XOpenDisplay(screen.encode())), window

    def atom(self, name):
        return self.x11.XInternAtom(self.display, name.encode(), 0)

    def send(self, to, event):
        self.x11.XSendEvent(self.display, ctypes.c_ulong(to), 0, ctypes.c_long(0), ctypes.byref(event))
        self.x11.XFlush(self.display)

    def tell(self, message, *data):
        event = Event()
        event.message = Message(MESSAGE, 0, 1, self.display.value, self.window, self.atom(message), 32,
                                (ctypes.c_long * 5)(*data))
        self.send(self.window, event)

    def end(self):
        self.x11.XCloseDisplay(self.display)


def close(screen, window):
    sender = Sender(screen, window)
    sender.tell("WM_PROTOCOLS", sender.atom("WM_DELETE_WINDOW"))
    sender.end()


def drop(screen, window, files):
    """Drops `files` by the protocol XDND, version 5, and returns when they were taken."""
    sender = Sender(screen, window)
    x11, display, nothing = sender.x11, sender.display, ctypes.c_ulong(0)
    root = ctypes.c_ulong(x11.XDefaultRootWindow(display))
    source = x11.XCreateSimpleWindow(display, root, 0, 0, 1, 1, 0, nothing, nothing)
    x11.XSetSelectionOwner(display, ctypes.c_ulong(sender.atom("XdndSelection")), ctypes.c_ulong(source), nothing)
    sender.tell("XdndEnter", source, 5 << 24, sender.atom("text/uri-list"))
    sender.tell("XdndPosition", source, 0, 600 << 16 | 300, 0, sender.atom("XdndActionCopy"))
    sender.tell("XdndDrop", source)
    names = "".join(f"file://{file}\r\n" for file in files).encode()
    event = Event()
    while not (event.type == MESSAGE and event.message.message == sender.atom("XdndFinished")):
        x11.XNextEvent(display, ctypes.byref(event))
        if event.type != REQUESTED:
            continue
        request = event.request
        x11.XChangeProperty(display, ctypes.c_ulong(request.requestor), ctypes.c_ulong(request.property),
                            ctypes.c_ulong(request.target), 8, 0, names, len(names))
        answer = Event()
        answer.notice = Notice(NOTIFIED, 0, 1, display.value, request.requestor, request.selection, request.target,
                               request.property, request.time)
        sender.send(request.requestor, answer)
    sender.end()
