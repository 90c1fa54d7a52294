// What the address asks for: #t=12.5&theme=dark&view=hand

/** The wishes after the `#`. */
export function wishes() {
  const asked = new URLSearchParams(location.hash.slice(1));
  const t = Number.parseFloat(asked.get("t") ?? "");
  const one = (name, of) => (of.includes(asked.get(name)) ? asked.get(name) : null);
  return { t: Number.isFinite(t) ? t : 0, theme: one("theme", ["light", "dark"]), view: one("view", ["all", "hand", "top"]) ?? "all" };
}
