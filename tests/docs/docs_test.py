#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The documents agree with the tree: docs_test.py ROOT. Prints what is wrong; exit code 1 then.

1 every path that README.md and docs/*.md name exists,
2 every model header of eos/ and material/ states its source before its first line of code,
3 every key that the case reader knows is in the user guide,
4 every case folder is complete, and its README is about files that exist.
"""
import pathlib
import re
import sys

# Headers of eos/ and material/ that hold no model of their own.
NOT_MODELS = {"eos/eos.hpp": "the closed set of models", "eos/state.hpp": "what a model returns",
              "eos/ideal_gas.hpp": "a definition", "material/flow.hpp": "what a law returns"}
NOT_HERE = ("build/", "runs/", "DIR/")  # made by building and running
SOURCE = re.compile(r"\b(18|19|20)\d\d\b|Theory Manual")


def paths_in(text, top):
    """Words that look like paths of the tree: in back quotes, or beginning with a folder of its top."""
    ends = r"\.(?:hpp|cpp|md|py|sh|toml|txt|csv)"
    quoted = re.findall(r"`([\w.\-/]+(?:/[\w.\-]*|" + ends + r"))`", text)
    bare = [w for w in re.findall(r"(?<![\w./\-])(?:\./)?([\w.\-]+/[\w.\-/]*)", text) if w.split("/")[0] in top]
    return sorted({w.removeprefix("./").rstrip(".") for w in quoted + bare})


def missing_paths(root, document):
    top = {p.name for p in root.iterdir() if p.is_dir()} - {"build", "runs"}
    for word in paths_in(document.read_text(encoding="utf-8"), top):
        if word.startswith(NOT_HERE) or "/" not in word and document.parent != root:
            continue
        if not (root / word).exists() and not (document.parent / word).exists():
            yield f"{document.relative_to(root)}: names {word}, which does not exist"


def headers_without_source(root):
    for header in sorted([*root.glob("eos/*.hpp"), *root.glob("material/*.hpp")]):
        name = header.relative_to(root).as_posix()
        head = header.read_text(encoding="utf-8").split("#pragma once")
        if name not in NOT_MODELS and not SOURCE.search(head[0]) and not SOURCE.search("".join(re.findall(r"///.*", head[-1]))):
            yield f"{name}: states no source (author and year, or a manual) in its head"


def keys_not_documented(root):
    reader = (root / "io/case_file.cpp").read_text(encoding="utf-8")
    guide = (root / "docs/user_guide.md").read_text(encoding="utf-8")
    lists = re.findall(r'(?:Section|Table) \w+\([^{;]*\{((?:\s*"\w+",?)+)\}', reader)
    keys = {k for part in lists for k in re.findall(r'"(\w+)"', part)}
    if len(keys) < 30:
        yield f"io/case_file.cpp: only {len(keys)} keys were found; this test no longer understands it"
    for key in sorted(keys):
        if not re.search(rf"\b{key}\b", guide):
            yield f"docs/user_guide.md: does not mention the key {key}"


def incomplete_cases(root):
    for case in sorted(p for p in (root / "cases").iterdir() if (p / "case.toml").exists() or p.is_dir()):
        for name in ("case.toml", "README.md", "reference.csv"):
            if not (case / name).is_file():
                yield f"cases/{case.name}: has no {name}"
        if (case / "README.md").is_file():
            yield from missing_paths(root, case / "README.md")


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    wrong = []
    for document in [root / "README.md", *sorted(root.glob("docs/*.md"))]:
        wrong += missing_paths(root, document)
    wrong += [*headers_without_source(root), *keys_not_documented(root), *incomplete_cases(root)]
    for line in wrong:
        print(line)
    print(f"{len(wrong)} faults")
    sys.exit(1 if wrong else 0)


main()
