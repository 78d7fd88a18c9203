# report.py: what a section found: tables, gates, notes; printed as text that is also Markdown, and written as JSON.
# SPDX-License-Identifier: Apache-2.0
import json
import math


class Section:
    """Results of one section."""

    def __init__(self, name, title):
        self.name, self.title = name, title
        self.tables, self.gates, self.notes, self.commands, self.skipped = [], [], [], [], None

    def table(self, columns, rows, caption=""):
        """columns: (key, format); rows: dicts. A missing or None value is shown as '-'."""
        self.tables.append((caption, columns, rows))

    def gate(self, what, passed, found, needed):
        self.gates.append({"gate": what, "passed": bool(passed), "found": found, "needed": needed})

    def note(self, text):
        self.notes.append(text)

    def command(self, text):
        if text not in self.commands:
            self.commands.append(text)

    def text(self):
        lines = [f"## {self.name}: {self.title}", ""]
        if self.skipped:
            return "\n".join(lines + [f"skipped: {self.skipped}", ""])
        for caption, columns, rows in self.tables:
            lines += ([caption, ""] if caption else []) + table_text(columns, rows) + [""]
        for gate in self.gates:
            word = "passed" if gate["passed"] else "MISSED"
            lines.append(f"* {word}: {gate['gate']}: {gate['found']} (needed: {gate['needed']})")
        lines += [f"* {note}" for note in self.notes]
        lines += [f"* `{command}`" for command in self.commands]
        return "\n".join(lines + [""])

    def json(self):
        return {"title": self.title, "skipped": self.skipped, "gates": self.gates, "notes": self.notes, "commands": self.commands,
                "tables": [{"caption": caption, "rows": rows} for caption, _, rows in self.tables]}


def cell_text(value, form):
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "-"
    return format(value, form) if form and not isinstance(value, str) else str(value)


def table_text(columns, rows):
    """Aligned columns, numbers to the right."""
    heads = [key for key, _ in columns]
    body = [[cell_text(row.get(key), form) for key, form in columns] for row in rows]
    widths = [max(len(line[i]) for line in [heads] + body) for i in range(len(heads))]
    right = [bool(form) for _, form in columns]

    def line(cells):
        return "| " + " | ".join(c.rjust(w) if r else c.ljust(w) for c, w, r in zip(cells, widths, right)) + " |"

    rule = "| " + " | ".join("-" * (w - 1) + ":" if r else "-" * w for w, r in zip(widths, right)) + " |"
    return [line(heads), rule] + [line(cells) for cells in body]


def plain(value):
    """NaN and infinity have no place in JSON; numpy numbers become Python's."""
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(inner) for inner in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def write_json(path, head, sections):
    with open(path, "w") as file:
        json.dump(plain({**head, "sections": {s.name: s.json() for s in sections}}), file, indent=1)
        file.write("\n")
