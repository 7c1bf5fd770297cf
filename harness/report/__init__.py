"""Tables, figures, HTML, Markdown, JSON, JUnit."""
