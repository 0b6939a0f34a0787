#!/usr/bin/python3
"""What a package says of itself: documents_test.py PROGRAM VERSION"""

import gzip
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM, VERSION = Path(sys.argv.pop(1)).resolve(), sys.argv.pop(1)


def run(*words, **options):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=True, **options)


def plain(page):
    """A page without its typography."""
    return re.sub(r"\\f[BR]|\\&", "", page).replace(r"\-", "-").replace(r"\e", "\\")


class Manual(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        (cls.folder / "script.py").write_text(
            "import argparse\nparser = argparse.ArgumentParser(description='Does it: script.py FILE')\n"
            "parser.add_argument('--how', help='in which way')\nparser.parse_args()\n")
        (cls.folder / "lame.py").write_text("import what_nobody_has\n")
        cls.said = run("/usr/bin/python3", ROOT / "scripts/man_pages.py", VERSION, "-o", cls.folder, PROGRAM,
                       f"armukf-script={cls.folder / 'script.py'}", f"armukf-lame={cls.folder / 'lame.py'}").stderr
        cls.pages = {path.name: gzip.decompress(path.read_bytes()).decode() for path in cls.folder.glob("*.gz")}

    def test_a_page_for_each_command_with_each_option_and_all_that_is_said_of_it(self):
        commands = re.findall(r"^  (\w+)  ", run(PROGRAM, "--help").stdout.split("Subcommands:")[1], re.M)
        self.assertEqual(set(self.pages), {"armukf.1.gz", "armukf-script.1.gz",
                                           *(f"armukf-{command}.1.gz" for command in commands)})
        for command in commands:
            said = run(PROGRAM, command, "--help").stdout
            page = " ".join(plain(self.pages[f"armukf-{command}.1.gz"]).replace(", -", ",-").lower().split())
            for line in said.replace(", -", ",-").lower().splitlines():
                for part in re.split(r"\s{2,}", line.strip().removesuffix(":").removeprefix("usage: ")):
                    self.assertIn(part, page, command)

    def test_a_script_has_the_name_that_it_is_installed_under(self):
        page = plain(self.pages["armukf-script.1.gz"])
        self.assertIn("armukf-script - Does it: armukf-script FILE", page)
        self.assertIn("--how HOW\nin which way", page)
        self.assertNotIn("script.py", page)

    def test_a_script_that_does_not_run_here_has_no_page(self):
        self.assertIn("no page of armukf-lame", self.said)

    @unittest.skipUnless(shutil.which("groff"), "no groff")
    def test_typesetter_has_nothing_to_complain_of(self):
        for name, page in self.pages.items():
            done = run("groff", "-man", "-ww", "-K", "utf8", "-T", "utf8", "-rLL=100n", input=page)
            self.assertEqual(done.stderr, "", name)


class Documents(unittest.TestCase):
    def test_changelog_ends_with_this_version(self):
        first = (ROOT / "data/package/changelog").read_text().splitlines()[0]
        self.assertEqual(first, f"armukf ({VERSION}) unstable; urgency=medium")

    def test_copyright_tells_the_licence_word_by_word(self):
        told = (ROOT / ".reuse/dep5").read_text().split("License: MIT\n")[-1].replace("\n .\n", "\n\n")
        licence = (ROOT / "LICENSE").read_text()
        self.assertEqual(told.split(), licence[licence.index("Permission"):].split())


if __name__ == "__main__":
    unittest.main()
