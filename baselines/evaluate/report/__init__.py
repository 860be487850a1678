"""The report of an evaluation: a web page with figures and a replay, and the same in Markdown."""
