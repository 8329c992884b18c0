"""What a program writes to a terminal of a width: terminal.py WIDTH PROGRAM [ARGUMENT...]. Ends as the program does.

The terminal stays until it is told the end: one that is hung up when its program ends may lose what it has not handed on.
"""
import fcntl
import os
import pty
import struct
import subprocess
import sys
import termios
import threading

END = b"\0"


def main(width, *command):
    reader, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, int(width), 0, 0))
    child = subprocess.Popen(command, stdin=terminal, stdout=terminal, stderr=terminal)
    threading.Thread(target=lambda: (child.wait(), os.write(terminal, END))).start()
    text = b""
    while not text.endswith(END):
        text += os.read(reader, 65536)
    sys.stdout.buffer.write(text[:-len(END)].replace(b"\r\n", b"\n"))
    sys.stdout.flush()
    return child.wait()


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
