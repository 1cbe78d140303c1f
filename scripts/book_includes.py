#!/usr/bin/env python3
"""Preprocessor of mdBook: includes files from outside of the book, and makes their links lead on from the page.

{{#include PATH}} with a PATH outside of docs/src is replaced by the file. Its relative links then lead
- to the page that includes the file which they name,
- to a picture in docs/, which `make doc` puts beside the pages,
- nowhere, if they name another file of the repository: the text stays.
Other includes are left to mdBook.
"""

import json
import posixpath
import re
import sys
from pathlib import Path

INCLUDE = re.compile(r"\{\{#include ([^}\s:]+)\}\}")
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")


def chapters(items):
    for item in items:
        chapter = item.get("Chapter") if isinstance(item, dict) else None
        if chapter:
            yield chapter
            yield from chapters(chapter["sub_items"])


class Book:
    def __init__(self, root, source):
        self.root, self.source = root, source
        self.pages = {}

    def included(self, page, path):
        """The file that a page includes, from the root of the repository; None: it is in the book."""
        target = (self.source / page).parent / path
        target = target.resolve()
        return None if target.is_relative_to(self.source) else target.relative_to(self.root)

    def note(self, page, text):
        for match in INCLUDE.finditer(text):
            file = self.included(page, match[1])
            if file:
                self.pages[file.as_posix()] = page

    def expand(self, page, text):
        def replace(match):
            file = self.included(page, match[1])
            if not file:
                return match[0]
            return self.relink(page, file, (self.root / file).read_text(encoding="utf-8"))

        return INCLUDE.sub(replace, text)

    def relink(self, page, file, text):
        here = posixpath.dirname(page)

        def replace(match):
            picture, label, target = match.groups()
            if re.match(r"[a-z]+:|#", target):
                return match[0]
            path, _, anchor = target.partition("#")
            path = posixpath.normpath(posixpath.join(file.parent.as_posix(), path))
            anchor = anchor and f"#{anchor}"
            for known in (path, f"{path}/README.md"):
                if known in self.pages:
                    return f"[{label}]({posixpath.relpath(self.pages[known], here)}{anchor})"
            if path.startswith("docs/src/"):
                return f"{picture}[{label}]({posixpath.relpath(path[len('docs/src/'):], here)}{anchor})"
            if picture and path.startswith("docs/"):
                return f"![{label}]({posixpath.relpath(path[len('docs/'):], here)})"
            return label

        lines = text.split("\n")
        fenced = False
        for number, line in enumerate(lines):
            fenced ^= line.lstrip().startswith("```")
            if not fenced and not line.startswith("    "):
                lines[number] = LINK.sub(replace, line)
        return "\n".join(lines)


def main():
    if sys.argv[1:2] == ["supports"]:
        return 0
    context, book = json.load(sys.stdin)
    folder = Path(context["root"]).resolve()
    expander = Book(folder.parent, folder / context["config"]["book"].get("src", "src"))
    items = book.get("items", book.get("sections"))
    pages = [chapter for chapter in chapters(items) if chapter.get("path")]
    for chapter in pages:
        expander.note(chapter["path"], chapter["content"])
    for chapter in pages:
        chapter["content"] = expander.expand(chapter["path"], chapter["content"])
    json.dump(book, sys.stdout)
    return 0


if __name__ == "__main__":
    sys.exit(main())
