"""Hooks of mkdocs: anchors as in the repository, a policy for each page that lets nothing in from elsewhere, and a search that works
for pages of a disk, too."""

import base64
import hashlib
import re
import typing
from pathlib import Path

SCRIPT = re.compile(r"<script>(.*?)</script>", re.DOTALL)
# attributes that would need 'unsafe-inline'
HANDLER = re.compile(r'\son\w+="[^"]*"')


def anchor(heading: str, _separator: str = "-") -> str:
    """The anchor of a heading, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def on_config(config: typing.Any) -> typing.Any:
    config["mdx_configs"].setdefault("toc", {})["slugify"] = anchor
    return config


def policy(html: str) -> str:
    """The Content-Security-Policy of a page: files of this site, and the page's own scripts by their hashes."""
    hashes = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in SCRIPT.findall(html)]
    scripts = " ".join(["'self'", *sorted({f"'sha256-{each}'" for each in hashes})])
    return (f"default-src 'none'; script-src {scripts}; style-src 'self' 'unsafe-inline'; img-src 'self' data:; font-src 'self' data:; "
            "connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'self'")


def on_post_page(output: str, **_: typing.Any) -> str:
    output = HANDLER.sub("", output)
    return output.replace("<head>", f'<head>\n    <meta http-equiv="Content-Security-Policy" content="{policy(output)}">', 1)


def on_post_template(output_content: str, template_name: str, **_: typing.Any) -> str:
    """404.html and the site map need the address of the site, which differs from server to server: an empty one is not written."""
    return "" if template_name in ("404.html", "sitemap.xml") else output_content


def on_post_build(config: typing.Any, **_: typing.Any) -> None:
    """The index of the search as a script, for search_from_disk.js: browsers read no JSON from a disk."""
    folder = Path(config["site_dir"]) / "search"
    index = (folder / "search_index.json").read_text(encoding="utf-8")
    (folder / "search_index.js").write_text(f"window.espalierSearchIndex = {index};\n", encoding="utf-8")
