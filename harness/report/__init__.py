"""Tables, figures, HTML, Markdown, JSON."""
