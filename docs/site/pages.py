"""Markdown as GitHub reads it, links by the titles of pages, and what the search looks through."""
import html
import json
import os
import re

from markdown import Extension
from markdown.blockprocessors import build_block_parser

titles = {}  # of pages, by their path, in the order of the navigation
sections = {}  # by the path of their page: address, page, heading, text


class IndentedByTwo(Extension):
    """What belongs to a list item is indented as far as its text, not by four blanks."""

    def extendMarkdown(self, md):
        md.tab_length = 2
        md.parser = build_block_parser(md)  # its parts keep the length that they were made with


def on_config(config):
    def note(entries):
        for entry in entries:
            for title, inside in entry.items():
                note(inside) if isinstance(inside, list) else titles.update({inside: title})

    note(config["nav"])
    config["markdown_extensions"].insert(0, IndentedByTwo())  # the others add their parts to that parser
    return config


def on_page_markdown(markdown, page, **_):
    """`a\\|b` in a cell is a|b, and a link that is called after a file gets the title of the page."""

    def titled(link):
        path = os.path.normpath(os.path.join(os.path.dirname(page.file.src_path), link[2]))
        return f"[{titles.get(path, link[1])}]({link[2]}{link[3]})"

    markdown = re.sub(r"\[([\w/]+\.md)\]\(([\w./]+)(#[^)]*|)\)", titled, markdown)
    return re.sub(r"(?m)^\|.*$", lambda row: re.sub(r"`[^`]*`", lambda code: code[0].replace("\\|", "|"), row[0]), markdown)


def on_page_content(content, page, **_):
    def plain(text):
        return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", text)).split())

    for part in re.split(r'(?=<h[1-4] id=")', content):
        heading = re.match(r'<h[1-4] id="([^"]*)">(.*?)</h\d>', part, re.S)
        if heading:
            address = f"{page.url}#{heading[1]}"
            text = [address, page.title, plain(heading[2]), plain(part[heading.end():])]
            sections.setdefault(page.file.src_path, []).append(text)
    return content


def on_post_build(config):
    found = [text for path in titles for text in sections.get(path, [])]
    with open(os.path.join(config["site_dir"], "sections.js"), "w", encoding="utf-8") as file:
        file.write("sections = " + json.dumps(found, ensure_ascii=False, separators=(",", ":")) + ";\n")
