#!/usr/bin/env python3
"""Prints how many tests passed, failed and were skipped: cases of suites, and other entries of ctest as one each.

usage: count_tests.py CTEST_REPORT GTEST_FOLDER | --self-test

A suite leaves GTEST_FOLDER/ENTRY.xml; one that crashed leaves none, and one that failed at its end leaves no failed case:
each counts as a failure.
"""
import pathlib
import sys
import tempfile
import xml.etree.ElementTree as ElementTree


def outcome(entry):
    """Of an entry of ctest's report, as a position in the counts."""
    if entry.get("status") == "notrun" or entry.find("skipped") is not None:
        return 2
    return 1 if entry.get("status") == "fail" or entry.find("failure") is not None else 0


def counts_of_suite(path):
    root = ElementTree.parse(path).getroot()
    cases = list(root.iter("testcase"))
    failed = sum(case.find("failure") is not None for case in cases)
    skipped = sum(case.get("result") == "skipped" for case in cases)
    return [len(cases) - failed - skipped, failed, skipped]


def count(report, folder):
    total = [0, 0, 0]
    for entry in ElementTree.parse(report).getroot().iter("testcase"):
        counts = [0, 0, 0]
        path = folder / (entry.get("name") + ".xml")
        if path.exists():
            counts = counts_of_suite(path)
        if sum(counts) == 0 or (outcome(entry) == 1 and counts[1] == 0):
            counts[outcome(entry)] += 1
        total = [a + b for a, b in zip(total, counts)]
    return total


def self_test():
    def suite(*cases):
        return f"<testsuites><testsuite>{''.join(cases)}</testsuite></testsuites>"

    passed, failed = '<testcase result="completed"/>', '<testcase result="completed"><failure/></testcase>'
    skipped = '<testcase result="skipped"/>'
    for status, cases, expected in [("run", [passed, passed], [2, 0, 0]), ("run", [passed, skipped], [1, 0, 1]),
                                    ("fail", [passed, failed, failed], [1, 2, 0]), ("fail", [passed], [1, 1, 0]),
                                    ("fail", None, [0, 1, 0]), ("run", None, [1, 0, 0]), ("notrun", None, [0, 0, 1]),
                                    ("fail", [], [0, 1, 0])]:
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "ctest.xml").write_text(f'<testsuite><testcase name="a.B" status="{status}"/></testsuite>')
            if cases is not None:
                (folder / "a.B.xml").write_text(suite(*cases))
            found = count(folder / "ctest.xml", folder)
            assert found == expected, (status, cases, found)


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return 0
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 1
    print(*count(sys.argv[1], pathlib.Path(sys.argv[2])))
    return 0


if __name__ == "__main__":
    sys.exit(main())
