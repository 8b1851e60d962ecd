// Motions of all blocks at a keyframe of the load history.
function motionsAt(at) {
  const {motions, scales, blocks} = data.history, parts = scales.length, all = data.blocks.map(() => scales.map(() => 0));
  blocks.forEach((block, row) => (all[block] = scales.map((scale, part) => scale * motions[at][parts * row + part])));
  return all;
}

// The load history: a chart of λ over displacement, and a slider along it. A keyframe is motions of all blocks, and joints that
// have slid and that have opened, each kind with its colour, width and dashes.
const loadHistory = (() => {
  const given = data.history;
  if (!given) return null;
  const slider = document.getElementById("loaded"), chart = document.querySelector(".chart");
  const {displacement: us, load_factor: loads, incremental} = given;
  const minus = (value) => String(+value.toPrecision(4)).replaceAll("-", "−");
  const peak = minus(+incremental.toPrecision(3));
  const [left, top, right, bottom] = [Math.max(40, 8 + 7 * peak.length), 12, 328, 118];
  const least = Math.min(0, ...loads, incremental), most = Math.max(0, ...loads, incremental);
  // Beyond the displacement at which λ is half its highest by the logarithm.
  const highest = Math.max(...loads.map(Math.abs)), half = Math.abs(us[loads.findIndex((load) => Math.abs(load) >= highest / 2)]) || 1;
  const scaled = (u) => Math.sign(u) * Math.log1p(Math.abs(u) / half);
  const first = Math.min(...us), last = Math.max(...us);
  const along = (u) => left + ((scaled(u) - scaled(first)) / (scaled(last) - scaled(first) || 1)) * (right - left);
  const x = us.map(along);
  const height = (load) => bottom - ((load - least) / (most - least || 1)) * (bottom - top);
  const y = loads.map(height);
  const text = (at, down, words, anchor = "end") => `<text x="${at}" y="${down}" text-anchor="${anchor}">${words}</text>`;
  const starts = given.events.map((event, at) => at > 0 && event !== given.events[at - 1]);
  const dots = x.map((_, at) => (starts[at] ? `<circle class="start" cx="${x[at]}" cy="${y[at]}" r="2.6"/>` : "")).join("");
  const ticks = [0];
  for (let u = 10 ** Math.ceil(Math.log10(half)); u <= last; u *= 10) if (along(u) > along(ticks.at(-1)) + 25) ticks.push(u);
  if (along(last) > along(ticks.at(-1)) + 45) ticks.push(+last.toPrecision(2));
  chart.innerHTML =
    `<path class="axes" d="M${left} ${top - 6}V${bottom}M${left} ${height(0)}H${right}${ticks.map((u) => `M${along(u)} ${bottom}v4`).join("")}"/>` +
    `<path class="incremental" d="M${left} ${height(incremental)}H${right}"/>` +
    `<polyline points="${x.map((at, number) => `${at},${y[number]}`).join(" ")}"/>${dots}<circle class="at" r="5.5"/>` +
    text(left - 5, height(incremental) + 4, peak) + text(left - 5, height(0) + 4, 0) +
    text(left - 5, (height(0) + height(incremental)) / 2, "λ") + ticks.map((u) => text(along(u), bottom + 16, minus(u), along(u) > right - 20 ? "end" : "middle")).join("") +
    text((left + right) / 2, bottom + 30, "displacement of the live load", "middle");
  const marker = chart.querySelector(".at");

  // Where the slider is: λ and displacement, what slid or opened, and what began last.
  function tell() {
    const at = +slider.value, [slid, open] = given.joints.map((kind) => kind[at].length);
    marker.setAttribute("cx", x[at]);
    marker.setAttribute("cy", y[at]);
    document.getElementById("now").textContent =
      `λ = ${minus(loads[at])}, displacement ${minus(us[at])}; joints slid: ${slid}, opened: ${open}`;
    const event = document.getElementById("event");
    if (event.textContent !== given.events[at]) event.textContent = given.events[at];
    slider.setAttribute("aria-valuetext", `λ = ${minus(loads[at])}`);
  }

  function place() {
    const at = +slider.value;
    figure.keyframe(motionsAt(at), given.marks.map(([colour, width, dashes], kind) => ({colour, width, dashes, joints: given.joints[kind][at]})));
  }

  chart.addEventListener("pointerdown", (event) => {
    const box = chart.getBoundingClientRect(), scale = 336 / box.width;
    const from = x.map((_, at) => Math.hypot(x[at] - (event.clientX - box.left) * scale, y[at] - (event.clientY - box.top) * scale));
    slider.value = from.indexOf(Math.min(...from));
    slider.dispatchEvent(new Event("input"));
  });
  tell();
  return {slider, tell, place};
})();
