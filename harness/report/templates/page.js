"use strict";
(() => {
  const FIRST = 25, DETAILS = 11, CAUSE = 15;  // rows shown at first; columns of the packed rows
  const table = document.querySelector("table.rows"), dialog = document.querySelector("dialog");
  for (const paper of document.querySelectorAll("button.paper")) paper.onclick = () => {
    const caption = paper.parentElement.querySelector("figcaption"), image = dialog.querySelector("img");
    image.src = paper.firstElementChild.src;
    image.alt = dialog.querySelector("b").textContent = paper.firstElementChild.alt;
    dialog.querySelector("p").textContent = caption.textContent;
    dialog.showModal();
  };
  if (self.DecompressionStream) unpack(JSON.parse(document.getElementById("packed").textContent)).then(sortAndFilter);

  async function unpack(text) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const columns = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).json();
    return (columns[0] || []).map((_, n) => ({ number: n + 1, cells: columns.map((column) => column[n]) }));
  }

  function sortAndFilter(rows) {
    const form = document.querySelector(".filters"), more = document.querySelector(".more"), fold = table.closest("details");
    const field = form.elements, output = form.querySelector("output"), heads = [...table.tHead.rows[0].cells];
    const columns = { verdict: 0, kind: 2, engine: 3, cause: CAUSE }, names = heads.map((head) => head.textContent);
    let ordered = rows, all = false, single = 0;
    form.hidden = false;
    document.querySelector(".first")?.remove();

    function element(tag, text, look = "") {
      const made = document.createElement(tag);
      made.textContent = text;
      made.className = look;
      return made;
    }
    function line(row) {
      const made = document.createElement("tr"), texts = row.cells.slice(DETAILS, CAUSE).filter(Boolean);
      made.id = `row-${row.number}`;
      made.className = row.number === single ? "target" : "";
      row.cells.slice(0, DETAILS).forEach((text, n) => {
        const cell = element("td", n > 1 || !texts.length ? text : "");
        if (n === 0) cell.replaceChildren(element("span", text, `badge ${text.replace(" ", "-")}`));
        if (n === 1 && texts.length) {
          const details = document.createElement("details");
          details.append(element("summary", text), ...texts.map((words) => element("p", words)));
          details.open = row.number === single;
          cell.append(details);
        }
        if (n === 10 && (parseFloat(text) > 100 || text[0] === ">")) cell.className = "over";
        cell.dataset.n = names[n]; // a phone shows each cell with its name
        made.append(cell);
      });
      return made;
    }
    function show() {
      const words = field.text.value.toLowerCase().split(/\s+/).filter(Boolean);
      const chosen = Object.entries(columns).filter(([name]) => field[name]?.value);
      const found = ordered.filter((row) => single ? row.number === single :
        chosen.every(([name, column]) => field[name].value === row.cells[column]) &&
        (!words.length || words.every((word) => (row.text ??= row.cells.join(" ").toLowerCase()).includes(word))));
      const shown = all ? found : found.slice(0, FIRST);
      table.tBodies[0].replaceChildren(...shown.map(line));
      table.classList.add("ready");
      output.value = `${found.length} of ${rows.length} rows`;
      more.hidden = found.length <= shown.length && !single;
      more.firstElementChild.textContent = `Show all ${single ? rows.length : found.length}`;
    }
    function sort(column, falling) {
      heads.forEach((head, n) => n === column ? head.setAttribute("aria-sort", falling ? "descending" : "ascending") : head.removeAttribute("aria-sort"));
      const key = (row) => column > 3 && column !== 6 ? parseFloat(row.cells[column]) : row.cells[column].toLowerCase();
      const missing = Number.isNaN;
      const order = (a, b) => missing(a) || missing(b) ? missing(a) - missing(b) : (falling ? -1 : 1) * (a < b ? -1 : a > b ? 1 : 0);
      ordered = column < 0 ? rows : rows.map((row) => [key(row), row]).sort((a, b) => order(a[0], b[0])).map((pair) => pair[1]);
      field.sort.value = column < 0 ? "" : String(column);
      show();
    }
    function reveal() { // a link to a row, to the rows of a cause, or to the table
      const [, kind, number] = location.hash.match(/^#(rows?)-?(\d*)$/) || [];
      if (!kind) return;
      fold.open = true;
      if (!number) return;
      form.reset();
      all = false;
      single = kind === "row" ? Number(number) : 0;
      if (kind === "rows") field.cause.value = number;
      sort(-1);
      fold.scrollIntoView();
    }
    heads.forEach((head, n) => { head.firstElementChild.onclick = () => sort(n, head.getAttribute("aria-sort") === "ascending"); });
    field.sort.onchange = () => sort(field.sort.value === "" ? -1 : Number(field.sort.value));
    form.onsubmit = () => false;
    for (const name of ["text", ...Object.keys(columns)]) if (field[name]) field[name].oninput = () => { single = 0; show(); };
    more.firstElementChild.onclick = () => { all = !single; single = 0; show(); };
    addEventListener("hashchange", reveal);
    show();
    reveal();
  }
})();
