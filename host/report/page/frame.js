// What every page has around its content: masthead, list of contents.

function themeButton() {
  const order = ["auto", "light", "dark"];
  const button = h("button", { type: "button", class: "quiet", title: "Light, dark, or as the system has it",
    onclick: () => {
      chosenTheme = order[(order.indexOf(chosenTheme) + 1) % order.length];
      button.textContent = `Theme: ${chosenTheme}`;
      redrawAll();
    } }, "Theme: auto");
  return button;
}

function masthead(kicker) {
  const made = [DATA.program, DATA.created.replace("T", " ").replace(/(:\d\d)?Z$/, " UTC")].filter(Boolean).join(" · ");
  document.getElementById("masthead").append(
    h("div", { class: "masthead-row" },
      h("div", {}, h("p", { class: "kicker" }, kicker), h("h1", {}, DATA.title),
        h("p", { class: "made" }, made)),
      h("div", { class: "actions" }, themeButton(),
        h("button", { type: "button", class: "quiet", onclick: () => window.print() }, "Print"))));
}

function contents() {
  const nav = document.getElementById("contents");
  const links = [...document.querySelectorAll("article.sample")].map((article) => h("li", {},
    h("a", { href: `#${article.id}`, class: "to-sample" }, article.querySelector("h2").textContent),
    h("ul", {}, [...article.querySelectorAll("section.part")].map((s) =>
      h("li", {}, h("a", { href: `#${s.id}` }, s.dataset.short))))));
  nav.append(h("ul", {}, links));
  if (!("IntersectionObserver" in window)) return;
  const byId = new Map([...nav.querySelectorAll("a")].map((a) => [a.getAttribute("href").slice(1), a]));
  const observer = new IntersectionObserver((entries) => {
    for (const e of entries) if (e.isIntersecting) {
      for (const a of byId.values()) a.removeAttribute("aria-current");
      byId.get(e.target.id).setAttribute("aria-current", "true");
    }
  }, { rootMargin: "-10% 0px -80% 0px" });
  for (const s of document.querySelectorAll("section.part")) observer.observe(s);
}
