"use strict";
// The filter of the book: rows by verdict and by words; a family without rows is hidden, and one with rows is opened.
{
  const [words, verdict, count] = [".filter input", ".filter select", ".filter output"].map((it) => document.querySelector(it));
  const rows = [...document.querySelectorAll("tr[data-verdict]")].map((row) => ({ row, text: row.textContent.toLowerCase() }));
  const families = [...document.querySelectorAll("details.family")];

  function filter() {
    const wanted = words.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    for (const { row, text } of rows) {
      row.hidden = (verdict.value && row.dataset.verdict !== verdict.value) || !wanted.every((it) => text.includes(it));
      shown += row.hidden ? 0 : 1;
    }
    for (const family of families) {
      family.hidden = !family.querySelector("tr[data-verdict]:not([hidden])");
      if (verdict.value || wanted.length > 0) family.open = !family.hidden;
    }
    count.textContent = `${shown} of ${rows.length} numbers`;
  }

  words.addEventListener("input", filter);
  verdict.addEventListener("change", filter);
  // A link of the summary picks its verdict.
  for (const link of document.querySelectorAll("a[data-pick]")) {
    link.addEventListener("click", () => { verdict.value = link.dataset.pick; words.value = ""; filter(); });
  }
  filter();
}
