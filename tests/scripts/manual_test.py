#!/usr/bin/python3
"""How the manual's examples are read and compared, its links checked and its generated parts made."""

import re
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.dont_write_bytecode = True
sys.path.insert(0, str(SCRIPTS))

import check_links  # noqa: E402
import manual_examples as examples  # noqa: E402
from program_help import Help  # noqa: E402

HELP = """What it does
Usage: armukf it [OPTIONS] FILE

Positionals:
  FILE TEXT REQUIRED          the record

Options:
  -h,--help                   Print this help message and exit
  --on-error TEXT:{stop,skip,missing}
                              at a row that cannot
                              be read
  -o,--output FOLDER REQUIRED folder to write to

Rows go out.
"""


class Steps(unittest.TestCase):
    def test_a_console_block_is_commands_and_what_they_print(self):
        text = "<!-- before: c -->\n<!-- run -->\n```console\n$ a\n> b\none\n...\n$ d\n```\n"
        steps = examples.steps_of(text)
        self.assertEqual([s.text for s in steps], ["c", "a\nb", "d"])
        self.assertEqual(steps[1].shown, ["one", "..."])

    def test_every_block_says_whether_it_is_run(self):
        self.assertRaises(examples.Fault, examples.steps_of, "```sh\na\n```\n")
        self.assertRaises(examples.Fault, examples.steps_of, "<!-- run -->\ntext\n```sh\na\n```\n")
        self.assertEqual(examples.steps_of("<!-- not run: a robot -->\n```sh\na\n```\n"), [])
        self.assertRaises(examples.Fault, examples.steps_of, "<!-- run twice -->\n```sh\na\n```\n")

    def test_all_pages_can_be_read(self):
        for page in examples.pages():
            root = examples.TREE if page == "README.md" else examples.MANUAL
            examples.steps_of((root / page).read_text(encoding="utf-8"))


class Running(unittest.TestCase):
    def run_step(self, text, **more):
        with tempfile.TemporaryDirectory() as folder:
            examples.run_step(examples.Step(1, "sh", text, **more), Path(folder), examples.environment("/bin/true"))

    def test_status_and_output_count(self):
        self.run_step("echo a; exit 2", status=2, shown=["a"])
        self.assertRaises(examples.Fault, self.run_step, "exit 2")
        self.assertRaises(examples.Fault, self.run_step, "false | true")
        self.assertRaises(examples.Fault, self.run_step, "echo b", shown=["a"])

    def test_what_shall_go_on_goes_on_and_is_ended(self):
        self.run_step("sleep 60", runs_for_s=0.1)
        self.assertRaises(examples.Fault, self.run_step, "true", runs_for_s=0.5)


class Lines(unittest.TestCase):
    def test_numbers_may_differ_a_little_and_words_not(self):
        self.assertTrue(examples.line_matches("k_a  11.8147 ± …", "  k_a     11.8150 ± 0.045    N.m/rad"))
        self.assertFalse(examples.line_matches("k_a  11.8147 ± …", "k_a 12.9 ± 0.045"))
        self.assertFalse(examples.line_matches("k_a 11.8", "k_b 11.8"))
        self.assertFalse(examples.line_matches("done", "done, but not well"))

    def test_they_come_in_order(self):
        self.assertIsNone(examples.missing_line(["a", "...", "c"], ["a", "b", "c"]))
        self.assertEqual(examples.missing_line(["c", "a"], ["a", "b", "c"]), "a")


class Pages(unittest.TestCase):
    def test_help_becomes_options_and_words(self):
        said = Help(HELP)
        self.assertEqual((" ".join(said.before).strip(), said.usage, " ".join(said.after)),
                         ("What it does", "armukf it [OPTIONS] FILE", "Rows go out."))
        self.assertEqual(said.sections["positionals"], [["FILE TEXT REQUIRED", "the record"]])
        self.assertEqual(said.sections["options"][1], ["--on-error TEXT:{stop,skip,missing}",
                                                       "at a row that cannot be read"])
        self.assertEqual(said.sections["options"][2], ["-o,--output FOLDER REQUIRED", "folder to write to"])

    def test_links_that_lead_nowhere_are_told(self):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder).resolve()
            (root / "a.html").write_text('<a href="b.html#x">x</a><a href="b.html#y">y</a><img src="c.png">'
                                         '<a href="https://example.org/d">d</a>', encoding="utf-8")
            (root / "b.html").write_text('<h1 id="x">x</h1>', encoding="utf-8")
            self.assertEqual(list(check_links.faults(root)),
                             ["a.html: b.html#y leads nowhere", "a.html: c.png leads nowhere"])

    def test_what_the_readme_links_is_there(self):
        text = (examples.TREE / "README.md").read_text(encoding="utf-8")
        links = re.findall(r"\]\(([^)#:]+)\)", text)
        self.assertGreater(len(links), 15)
        self.assertEqual([link for link in links if not (examples.TREE / link).exists()], [])


if __name__ == "__main__":
    unittest.main()
