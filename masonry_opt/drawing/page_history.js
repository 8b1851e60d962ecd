// Return the motions of all blocks at a keyframe of the load history.
function motionsAt(at) {
  const {motions, scales, blocks} = data.history, parts = scales.length, all = data.blocks.map(() => scales.map(() => 0));
  blocks.forEach((block, row) => (all[block] = scales.map((scale, part) => scale * motions[at][parts * row + part])));
  return all;
}

// Load history: a chart of λ over displacement, and a slider that selects a keyframe. A keyframe has the motions of
// all blocks, the joints that have slid, and the joints that are open. Both kinds of joints have a colour, width and
// dashes. The value is null if the result has no load history.
const loadHistory = (() => {
  const keyframes = data.history;
  if (!keyframes) return null;
  const slider = document.getElementById("loaded"), chart = document.querySelector(".chart");
  const {displacement: displacements, load_factor: loads, incremental} = keyframes;
  const digits = (value) => String(+value.toPrecision(4)).replaceAll("-", "−");
  const peak = digits(+incremental.toPrecision(3));
  const [left, top, right, bottom] = [Math.max(40, 8 + 7 * peak.length), 12, 328, 118];
  const least = Math.min(0, ...loads, incremental), most = Math.max(0, ...loads, incremental);
  // The horizontal scale is u -> sign(u) log(1 + |u| / half): about linear up to the displacement ``half`` at which λ
  // first reaches half its highest value, and logarithmic far beyond.
  const highest = Math.max(...loads.map(Math.abs)), half = Math.abs(displacements[loads.findIndex((load) => Math.abs(load) >= highest / 2)]) || 1;
  const scaled = (u) => Math.sign(u) * Math.log1p(Math.abs(u) / half);
  const first = Math.min(...displacements), last = Math.max(...displacements);
  const along = (u) => left + ((scaled(u) - scaled(first)) / (scaled(last) - scaled(first) || 1)) * (right - left);
  const x = displacements.map(along);
  const height = (load) => bottom - ((load - least) / (most - least || 1)) * (bottom - top);
  const y = loads.map(height);
  const text = (at, down, words, anchor = "end") => `<text x="${at}" y="${down}" text-anchor="${anchor}">${words}</text>`;
  const starts = keyframes.events.map((event, at) => at > 0 && event !== keyframes.events[at - 1]);
  const dots = x.map((_, at) => (starts[at] ? `<circle class="start" cx="${x[at]}" cy="${y[at]}" r="2.6"/>` : "")).join("");
  const ticks = [0];
  for (let u = 10 ** Math.ceil(Math.log10(half)); u <= last; u *= 10) if (along(u) > along(ticks.at(-1)) + 25) ticks.push(u);
  if (along(last) > along(ticks.at(-1)) + 45) ticks.push(+last.toPrecision(2));
  chart.innerHTML =
    `<path class="axes" d="M${left} ${top - 6}V${bottom}M${left} ${height(0)}H${right}${ticks.map((u) => `M${along(u)} ${bottom}v4`).join("")}"/>` +
    `<path class="incremental" d="M${left} ${height(incremental)}H${right}"/>` +
    `<polyline points="${x.map((at, number) => `${at},${y[number]}`).join(" ")}"/>${dots}<circle class="at" r="5.5"/>` +
    text(left - 5, height(incremental) + 4, peak) + text(left - 5, height(0) + 4, 0) +
    text(left - 5, (height(0) + height(incremental)) / 2, "λ") + ticks.map((u) => text(along(u), bottom + 16, digits(u), along(u) > right - 20 ? "end" : "middle")).join("") +
    text((left + right) / 2, bottom + 30, "displacement of the live load", "middle");
  const marker = chart.querySelector(".at");

  // Show the numbers of the keyframe at the slider: λ, displacement, joints that slid or opened, and the last event.
  function update() {
    const at = +slider.value, [slid, open] = keyframes.joints.map((kind) => kind[at].length);
    marker.setAttribute("cx", x[at]);
    marker.setAttribute("cy", y[at]);
    document.getElementById("now").textContent =
      `λ = ${digits(loads[at])}, displacement ${digits(displacements[at])}; joints that have slid: ${slid}, joints that are open: ${open}`;
    const event = document.getElementById("event");
    if (event.textContent !== keyframes.events[at]) event.textContent = keyframes.events[at];
    slider.setAttribute("aria-valuetext", `λ = ${digits(loads[at])}`);
  }

  // Move the blocks of the figure to the keyframe at the slider.
  function moveBlocks() {
    const at = +slider.value;
    figure.keyframe(motionsAt(at), keyframes.marks.map(([colour, width, dashes], kind) => ({colour, width, dashes, joints: keyframes.joints[kind][at]})));
  }

  chart.addEventListener("pointerdown", (event) => {
    const box = chart.getBoundingClientRect(), scale = 336 / box.width;
    const from = x.map((_, at) => Math.hypot(x[at] - (event.clientX - box.left) * scale, y[at] - (event.clientY - box.top) * scale));
    slider.value = from.indexOf(Math.min(...from));
    slider.dispatchEvent(new Event("input"));
  });
  update();
  return {slider, update, moveBlocks};
})();
