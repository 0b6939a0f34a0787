#!/usr/bin/python3
"""Whether armukf says the same on another processor: runs the short record through two builds and
compares every number of rows and reports.

    same_numbers.py PROGRAM --build x86-64-v3 --against x86-64-v2
        two of the builds that the dynamic loader chooses between
    same_numbers.py PROGRAM --foreign qemu-aarch64 -L SYSROOT OTHER_PROGRAM
        this machine's program and one that the words after --foreign run

Exit status 1 if they differ by more than --tolerance, 77 if this processor cannot run the build.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import agreement

LOADER = "/lib64/ld-linux-x86-64.so.2"
RECORD = Path(__file__).resolve().parents[2] / "data" / "short_record.csv"
CANNOT = 77  # CTest calls it skipped


def arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--build", help="processor whose build is to be run")
    parser.add_argument("--against", help="processor of the build to compare with")
    parser.add_argument("--filters", nargs="+", help="default: all that there are")
    parser.add_argument("--tolerance", type=float, default=1e-9, help="relative, see agreement.py")
    parser.add_argument("--foreign", nargs=argparse.REMAINDER, help="command of the other program")
    given = parser.parse_args()
    if bool(given.foreign) == bool(given.build) or bool(given.build) != bool(given.against):
        parser.error("either --build and --against, or --foreign")
    return given


def output(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))}: exit status {done.returncode}\n{done.stderr}")
    return done.stdout


def runs_here(processor):
    """Whether the dynamic loader takes this processor to be at least that one."""
    return re.search(rf"^\s*{processor} \(supported", output(LOADER, "--help"), re.MULTILINE)


def under(processor, program):
    """The command that runs the program with that build of the library. The baseline lies outside of
    the loader's folders: it is left if the loader may look into no other's."""
    return [LOADER, "--glibc-hwcaps-mask", processor, program]


def filters(program):
    names = re.search(r"--filter \S+ +one of ([a-z_, \n]+);", output(program, "estimate", "--help"))
    return names[1].replace(",", " ").split()


def jobs(chosen):
    """Name and words of each job, rows or nothing on its standard output; a report goes to a file."""
    for name in chosen:
        yield f"estimate, {name}", ["estimate", RECORD, "--quiet", "--filter", name]
    yield "smooth", ["smooth", RECORD, "--quiet"]
    yield "fit", ["fit", RECORD, "--quiet"]
    yield "evaluate", ["evaluate", RECORD, "--quiet"]


def rows_and_report(command, words):
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        rows = output(*command, *words, "--json", report)
        return rows, report.read_text()


def compare(one, two, words):
    difference = agreement.Difference()
    (rows, report), (other_rows, other_report) = (rows_and_report(c, words) for c in (one, two))
    if rows or other_rows:
        agreement.compare_rows(rows, other_rows, difference)
    agreement.compare_reports(report, other_report, difference)
    return difference


def compare_all(one, two, given):
    """Prints a line a job; the number of jobs that differ by more than is allowed."""
    faults = 0
    print(f"largest relative difference, {given.tolerance:g} allowed:")
    for name, words in jobs(given.filters or filters(given.program)):
        begin = time.monotonic()
        difference = compare(one, two, words)
        excessive = difference.size > given.tolerance
        faults += excessive
        print(f"  {name:<24} {difference}{'  TOO MUCH' if excessive else ''}"
              f"  ({time.monotonic() - begin:.1f} s)", flush=True)
    return faults


def main():
    given = arguments()
    if given.foreign:
        one, two = [given.program], given.foreign
        print(f"{output(*one, '--version').strip()} beside {output(*two, '--version').strip()}")
        return 1 if compare_all(one, two, given) else 0
    for processor in (given.build, given.against):
        if not runs_here(processor):
            print(f"{processor}: not run, this processor cannot")
            return CANNOT
        version = output(*under(processor, given.program), "--version")
        if f"built for {processor})" not in version:
            print(f"asked for {processor}, the loader took {version}")
            return 1
    print(f"{given.build} beside {given.against}")
    return 1 if compare_all(under(given.build, given.program), under(given.against, given.program),
                            given) else 0


if __name__ == "__main__":
    sys.exit(main())
