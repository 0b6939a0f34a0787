"""What a program says of itself by --help, taken apart: for man pages, and for the manual."""

import re
import subprocess

SECTION = re.compile(r"([A-Z][a-z]+|positional arguments|options):$")
USAGE = re.compile(r"usage: *(.*)", re.IGNORECASE)
ENTRY = re.compile(r"  (\S.*?)(?:\s{2,}(\S.*))?$")
COLUMN = 30  # where CLI11 begins to say what an option does
INDENTED = re.compile(r"\s+\S")


class Help:
    """Help taken apart: usage, the entries of its sections as (names, text), and other lines."""

    def __init__(self, text):
        self.usage, self.sections, self.before, self.after = "", {}, [], []
        entries, in_usage = None, False
        lines = text.splitlines()
        for line, following in zip(lines, [*lines[1:], ""]):
            if match := USAGE.match(line):
                self.usage, in_usage = match[1], True
            elif in_usage and INDENTED.match(line):
                self.usage += " " + line.strip()
            elif match := SECTION.match(line):
                entries = self.sections.setdefault(match[1].lower(), [])
            elif entries is None or (not line and not entries):
                (self.after if self.sections else self.before).append(line)
            elif not line:
                entries = None
            elif ENTRY.match(line):
                entries.append(names_and_text(line, following))
            else:
                entries[-1][1] = f"{entries[-1][1]} {line.strip()}".strip()
            in_usage = in_usage and (INDENTED.match(line) or USAGE.match(line))


def names_and_text(line, following):
    """Of an entry. The text begins in a column of its own, after one space if need be; where the names leave
    no room, in the line that follows."""
    names, text = ENTRY.match(line).groups()
    if text is None and not INDENTED.match(following[2:]) and line[COLUMN - 1:COLUMN] == " ":
        names, text = line[:COLUMN], line[COLUMN:]
    return [names.strip(), text or ""]


def help_of(*words):
    done = subprocess.run([str(word) for word in words] + ["--help"], capture_output=True, text=True, check=False)
    return Help(done.stdout) if done.returncode == 0 else None
