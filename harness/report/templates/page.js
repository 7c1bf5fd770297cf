"use strict";
(() => {
  const table = document.querySelector("table.rows"), dialog = document.querySelector("dialog");
  sortAndFilter(table, document.querySelector(".filters"), document.querySelector(".more"));
  for (const paper of document.querySelectorAll("button.paper")) paper.onclick = () => {
    const caption = paper.parentElement.querySelector("figcaption"), image = dialog.querySelector("img");
    image.src = paper.firstElementChild.src;
    image.alt = dialog.querySelector("b").textContent = paper.firstElementChild.alt;
    dialog.querySelector("p").textContent = caption.textContent;
    dialog.showModal();
  };

  function sortAndFilter(table, form, more) {
    const first = 25, body = table.tBodies[0], rows = [...body.rows], heads = [...table.tHead.rows[0].cells];
    const field = form.elements, output = form.querySelector("output"), places = { verdict: 0, kind: 2, engine: 3 };
    const names = heads.map((head) => head.textContent), fold = table.closest("details");
    let all = false;
    form.hidden = false;
    const text = (row, column) => row.cells[column].textContent.trim();

    function show() {
      const words = field.text.value.toLowerCase().split(/\s+/).filter(Boolean);
      const found = [...body.rows].filter((row) =>
        Object.entries(places).every(([name, column]) => !field[name].value || field[name].value === text(row, column)) &&
        (!words.length || words.every((word) => row.textContent.toLowerCase().includes(word))));
      const shown = new Set(all ? found : found.slice(0, first));
      for (const row of rows) row.hidden = !shown.has(row);
      // a phone shows each cell with its name; a screen reader still reads a table
      for (const row of shown) if (!row.ready) [...row.cells].forEach((cell, n) => { cell.dataset.n = names[n]; row.ready = true; });
      table.classList.add("ready");
      output.value = `${found.length} of ${rows.length} rows`;
      more.hidden = found.length <= shown.size;
      more.firstElementChild.textContent = `Show all ${found.length}`;
    }
    function sort(column, falling) {
      heads.forEach((head, n) => n === column ? head.setAttribute("aria-sort", falling ? "descending" : "ascending") : head.removeAttribute("aria-sort"));
      const value = (row) => column > 3 && column !== 6 ? parseFloat(text(row, column)) : text(row, column).toLowerCase();
      const missing = Number.isNaN;
      const order = (a, b) => missing(a) || missing(b) ? missing(a) - missing(b) : (falling ? -1 : 1) * (a < b ? -1 : a > b ? 1 : 0);
      body.append(...(column < 0 ? rows : rows.map((row) => [value(row), row]).sort((a, b) => order(a[0], b[0])).map((pair) => pair[1])));
      field.sort.value = column < 0 ? "" : String(column);
      show();
    }
    function reveal() { // a link to a row that is folded or filtered away
      const row = rows.find((one) => `#${one.id}` === location.hash);
      if (row || location.hash === `#${fold.id}`) fold.open = true;
      if (!row) return;
      if (row.hidden) { all = true; form.reset(); sort(-1); }
      row.querySelector("details")?.setAttribute("open", "");
      row.scrollIntoView();
    }
    heads.forEach((head, n) => { head.firstElementChild.onclick = () => sort(n, head.getAttribute("aria-sort") === "ascending"); });
    field.sort.onchange = () => sort(field.sort.value === "" ? -1 : Number(field.sort.value));
    form.onsubmit = () => false;
    for (const name of ["text", ...Object.keys(places)]) field[name].oninput = show;
    more.firstElementChild.onclick = () => { all = true; show(); };
    addEventListener("hashchange", reveal);
    show();
    reveal();
  }
})();
