"""Tables of results as text, described once for the terminal, Markdown and HTML."""
