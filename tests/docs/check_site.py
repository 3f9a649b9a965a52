"""check_site.py SITE: every link of a page leads to a file or place of the site, nothing is loaded from the network, and
every page can be reached from the navigation. Prints what is wrong, a line each; the exit code is 1 if anything is."""
import os
import sys
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """The links and places of one page, and what it loads; of links in the navigation that they are."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loads, self.navigation, self.places = [], [], [], set()
        self.nav_depth = 0
        with open(path, encoding="utf-8") as file:
            self.feed(file.read())

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.places.update(given[key] for key in ("id", "name") if given.get(key))
        if tag == "nav":
            self.nav_depth += 1
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
            if self.nav_depth:
                self.navigation.append(given["href"])
        if tag in ("img", "script", "iframe") and given.get("src"):
            self.loads.append(given["src"])
        if tag == "link" and given.get("rel") != "canonical" and given.get("href"):
            self.loads.append(given["href"])

    def handle_endtag(self, tag):
        if tag == "nav":
            self.nav_depth -= 1


def complaints(site):
    paths = [os.path.join(folder, name) for folder, _, names in os.walk(site) for name in names]
    pages = {path: Page(path) for path in paths if path.endswith(".html")}
    reached = set()
    for path, page in sorted(pages.items()):
        where = os.path.relpath(path, site)
        for link in page.links + page.loads:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                if link in page.loads and parts.scheme != "data":
                    yield f"{where} loads {link} from the network"
                continue
            target = path
            if parts.path:
                target = os.path.normpath(os.path.join(os.path.dirname(path), unquote(parts.path)))
            if not os.path.isfile(target):
                yield f"{where} links to {link}, and there is no such file"
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].places:
                yield f"{where} links to {link}, and the page has no such place"
            if link in page.navigation:
                reached.add(target)
    for path in paths:
        if path.endswith(".css"):
            with open(path, encoding="utf-8") as file:
                if "url(http" in file.read().replace('"', "").replace("'", ""):
                    yield f"{os.path.relpath(path, site)} loads from the network"
    for path in sorted(set(pages) - reached):
        if os.path.basename(path) != "404.html":
            yield f"{os.path.relpath(path, site)} is not in the navigation"


found = list(complaints(sys.argv[1]))
print("\n".join(found) or "every link leads somewhere")
sys.exit(1 if found else 0)
