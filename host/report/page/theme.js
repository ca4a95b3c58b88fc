// Light and dark, and one colour per wavelength that stays near its hue in both.

const DATA = JSON.parse(document.getElementById("umov-data").textContent);

// nm, colour on white, colour on near-black. Beyond the visible the scale goes on through plum to slate.
const SPECTRUM = [
  [380, "#6a3fb5", "#b79bf0"], [440, "#3454d1", "#8ea6ff"], [480, "#0b79b8", "#5cc0f5"],
  [505, "#0a8f80", "#45d3c0"], [532, "#16883a", "#4fd07a"], [560, "#5f8a0c", "#a5d34a"],
  [580, "#9a7a00", "#e0c23c"], [600, "#c86a06", "#f5a94d"], [633, "#d4331d", "#ff7d66"],
  [680, "#a8152a", "#f2677c"], [750, "#8c2152", "#ea79ae"], [814, "#74296f", "#d38ad0"],
  [1064, "#46397f", "#a79be0"], [2000, "#3d4f63", "#9db3c8"], [6000, "#2f3b46", "#c3ced8"],
];
const SYMBOLS = ["circle", "square", "diamond", "triangle-up", "cross", "triangle-down", "star", "hexagon"];

// Where curves of two wavelengths coincide, the later one's dashes let the earlier one show.
const DASHES = ["solid", "10px,5px", "3px,5px", "14px,4px,3px,4px"];

const scheme = window.matchMedia("(prefers-color-scheme: dark)");
let chosenTheme = "auto";
let printing = false;

function isDark() {
  if (printing) return false;
  return chosenTheme === "auto" ? scheme.matches : chosenTheme === "dark";
}

function mixHex(a, b, t) {
  const part = (hex, i) => parseInt(hex.slice(1 + 2 * i, 3 + 2 * i), 16);
  return "#" + [0, 1, 2].map((i) =>
    Math.round(part(a, i) + (part(b, i) - part(a, i)) * t).toString(16).padStart(2, "0")).join("");
}

function wavelengthColor(nm) {
  const shade = isDark() ? 2 : 1;
  if (nm <= SPECTRUM[0][0]) return SPECTRUM[0][shade];
  for (let i = 1; i < SPECTRUM.length; i++) {
    const [a, b] = [SPECTRUM[i - 1], SPECTRUM[i]];
    if (nm <= b[0]) return mixHex(a[shade], b[shade], (nm - a[0]) / (b[0] - a[0]));
  }
  return SPECTRUM[SPECTRUM.length - 1][shade];
}

function withAlpha(hex, alpha) {
  const part = (i) => parseInt(hex.slice(1 + 2 * i, 3 + 2 * i), 16);
  return `rgba(${part(0)},${part(1)},${part(2)},${alpha})`;
}

function wavelengthSymbol(sample, nm) {
  return SYMBOLS[Math.max(0, sample.wavelengths_nm.indexOf(nm)) % SYMBOLS.length];
}

function wavelengthDash(sample, nm) {
  return DASHES[Math.max(0, sample.wavelengths_nm.indexOf(nm)) % DASHES.length];
}

function palette() {
  return isDark()
    ? { text: "#e6e9ee", soft: "#a3abb8", line: "#333a45", zero: "#596273", paper: "#15181d", accent: "#7fb2ff",
      mark: "#8c95a4" }
    : { text: "#1c222b", soft: "#5a6472", line: "#e3e7ec", zero: "#aab3bf", paper: "#ffffff", accent: "#1f5fbf",
      mark: "#7a8492" };
}

function applyTheme() {
  document.documentElement.dataset.theme = isDark() ? "dark" : "light";
}
