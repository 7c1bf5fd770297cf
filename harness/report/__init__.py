"""Reports: pages, figures and films, made of sections and of tables of rows."""
