"""Links of installed documents and scenes that lead nowhere: links.py ROOT... prints them. ROOT is what packages were unpacked into."""

import json
import os
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from markdown_it import MarkdownIt


def links_of_markdown(text):
    for token in MarkdownIt().parse(text):
        for inside in token.children or ():
            yield from (value for key, value in inside.attrs.items() if key in ("href", "src"))


def links_of_html(text):
    found = []

    class Reader(HTMLParser):
        def handle_starttag(self, tag, attrs):
            found.extend(value for key, value in attrs if key in ("href", "src") and value)
    Reader().feed(text)
    return found


def links_of_scene(text):
    schema = json.loads(text).get("$schema")
    return [schema] if schema else []


READERS = {".md": links_of_markdown, ".html": links_of_html, ".scene.json": links_of_scene, ".arm.json": links_of_scene}


def present(target, roots):
    """Whether one of the roots has it. A symbolic link may lead to what this machine has of Debian, which the package depends on."""
    for root in roots:
        if (root / target).is_symlink():
            return any((other / os.path.normpath(Path(target).parent / os.readlink(root / target))).exists() for other in (*roots, Path("/")))
        if (root / target).exists():
            return True
    return False


def dead_links(*roots):
    """(number of links, [(file, link)] of the dead). What one package links to may be in another one."""
    count, dead = 0, []
    for root in map(Path, roots):
        for file in sorted(root.rglob("*")):
            links = next((links for suffix, links in READERS.items() if file.name.endswith(suffix)), None)
            if links is None or not file.is_file():
                continue
            for link in links(file.read_text()):
                parts = urlsplit(link)
                if parts.scheme or parts.netloc or not parts.path:
                    continue
                count += 1
                target = os.path.normpath(file.parent.relative_to(root) / unquote(parts.path))
                if not present(target, [*map(Path, roots)]):
                    dead.append((str(file.relative_to(root)), link))
    return count, dead


if __name__ == "__main__":
    count, dead = dead_links(*sys.argv[1:])
    print(*(f"{file}: {link}" for file, link in dead), f"{len(dead)} of {count} links are dead", sep="\n")
    sys.exit(bool(dead))
