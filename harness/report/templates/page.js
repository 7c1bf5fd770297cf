"use strict";
(() => {
  document.documentElement.classList.remove("nojs");
  const table = document.querySelector("table.checks");
  if (table) {
    for (const [selector, role] of [["thead, tbody", "rowgroup"], ["thead tr", "row"], ["th", "columnheader"]])
      for (const node of table.querySelectorAll(selector)) node.setAttribute("role", role);
    sortAndFilter(table);
  }
  enlarge(document.querySelector("dialog"), [...document.querySelectorAll("a.paper")]);

  // a link to a row that is filtered away, or not shown yet, shows it first
  function sortAndFilter(table) {
    const first = 25, body = table.tBodies[0], rows = [...body.rows], form = document.querySelector(".filters");
    const more = document.querySelector(".more"), heads = [...table.tHead.rows[0].cells];
    const { text, kind, verdict, sorted } = form.elements, count = form.querySelector("output");
    let all = false;

    // of thousands of rows, words are gathered when a filter asks for them, roles told when a row is shown
    function wordsOf(row) {
      row.words ??= [...row.cells].filter((cell) => !cell.classList.contains("n")).map((cell) => cell.textContent).join(" ").toLowerCase();
      return row.words;
    }
    // laid out as cards on a phone, it stays a table for those who have it read out
    function tell(row) {
      if (row.hasAttribute("role")) return;
      row.setAttribute("role", "row");
      for (const cell of row.cells) cell.setAttribute("role", "cell");
    }

    function show() {
      const words = text.value.toLowerCase().split(/\s+/).filter(Boolean);
      const fits = (row) => words.every((word) => wordsOf(row).includes(word)) &&
        (!kind.value || row.dataset.kind === kind.value) && (!verdict.value || row.dataset.verdict === verdict.value);
      const found = [...body.rows].filter(fits), shown = new Set(all ? found : found.slice(0, first));
      rows.forEach((row) => { row.hidden = !shown.has(row); });
      shown.forEach(tell);
      table.classList.add("ready");
      count.value = `${found.length} of ${rows.length} checks`;
      more.hidden = found.length <= shown.size;
      more.firstElementChild.textContent = `Show all ${found.length}`;
    }
    function value(row, column) {
      const cell = row.cells[column], said = cell.dataset.v ?? cell.textContent.trim();
      if (!cell.classList.contains("n") && !cell.dataset.v) return said.toLowerCase();
      return Number(said.replace("inf", "Infinity").replace(/^(?:> )?(\S+) %$/, "$1") || NaN);
    }
    function compare(a, b, sign) {
      if (Number.isNaN(a) || Number.isNaN(b)) return Number.isNaN(a) - Number.isNaN(b); // missing ones last
      return sign * (a < b ? -1 : a > b ? 1 : 0);
    }
    function sort(column, direction) {
      heads.forEach((head, i) => {
        if (i === column && direction) head.setAttribute("aria-sort", direction); else head.removeAttribute("aria-sort");
      });
      const sign = direction === "descending" ? -1 : 1;
      const order = direction
        ? rows.map((row) => [value(row, column), row]).sort((a, b) => compare(a[0], b[0], sign)).map((pair) => pair[1])
        : rows;
      body.append(...order);
      sorted.value = direction ? `${column} ${direction}` : "";
      show();
    }
    heads.forEach((head, column) => head.querySelector("button").addEventListener("click", () => {
      const next = { ascending: "descending", descending: "" };
      const now = head.getAttribute("aria-sort");
      sort(column, now === null ? "ascending" : next[now]);
    }));
    sorted.addEventListener("change", () => {
      const [column, direction] = sorted.value.split(" ");
      sort(Number(column), direction || "");
    });
    form.addEventListener("submit", (event) => event.preventDefault());
    for (const field of [text, kind, verdict]) field.addEventListener("input", show);
    more.firstElementChild.addEventListener("click", () => { all = true; show(); });
    function reveal() {
      const row = rows.find((one) => "#" + one.id === location.hash), fold = table.closest("details.fold");
      if (fold && (row || location.hash === "#" + fold.id)) fold.open = true;
      if (!row) return;
      if (row.hidden) { all = true; form.reset(); sort(0, ""); }
      row.querySelector("details")?.setAttribute("open", "");
      row.scrollIntoView();
    }
    addEventListener("hashchange", reveal);
    show();
    reveal();
  }

  function enlarge(dialog, links) {
    if (!dialog) return;
    const [title, out, fit, into, back, on, close] = dialog.querySelectorAll("header > *");
    const frame = dialog.querySelector(".zoom"), image = frame.querySelector("img"), words = dialog.querySelector("p");
    let at = 0, scale = 1;
    function zoom(to) {
      scale = Math.min(8, Math.max(1, to));
      const small = links[at].querySelector("img"), aspect = small.getAttribute("width") / small.getAttribute("height");
      image.style.width = `${scale * Math.min(frame.clientWidth - 16, (frame.clientHeight - 16) * aspect)}px`;
      frame.style.cursor = scale > 1 ? "zoom-out" : "zoom-in";
    }
    function open(index) {
      at = (index + links.length) % links.length;
      const caption = links[at].parentElement.querySelector("figcaption");
      image.src = links[at].querySelector("img").src;
      image.alt = title.textContent = caption.querySelector("b").textContent;
      words.textContent = caption.dataset.text;
      if (!dialog.open) dialog.showModal();
      zoom(1);
    }
    links.forEach((link, index) => link.addEventListener("click", (event) => {
      if (event.ctrlKey || event.metaKey || event.shiftKey) return;
      event.preventDefault();
      open(index);
    }));
    out.onclick = () => zoom(scale / 1.5);
    into.onclick = () => zoom(scale * 1.5);
    fit.onclick = () => zoom(1);
    image.onclick = () => zoom(scale > 1 ? 1 : 2.5);
    back.onclick = () => open(at - 1);
    on.onclick = () => open(at + 1);
    close.onclick = () => dialog.close();
    dialog.addEventListener("close", () => links[at].focus());
    dialog.addEventListener("keydown", (event) => {
      const act = { ArrowLeft: back, ArrowRight: on, "+": into, "-": out, 0: fit }[event.key];
      if (act) { event.preventDefault(); act.click(); }
    });
    addEventListener("resize", () => dialog.open && zoom(scale));
  }
})();
