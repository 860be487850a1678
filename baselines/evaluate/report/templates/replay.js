// The replay: what is chosen is unpacked, and shown side by side at the same time and scale.
(() => {
  const NONE = "none"; // in place of a player: no right side
  const PATIENCE = 250; // ms before the address is changed

  const part = (name) => document.querySelector(`[data-replay="${name}"]`);
  const conditions = Object.fromEntries(world.conditions.map((condition) => [condition.name, condition]));
  const players = Object.fromEntries(world.players.map((player) => [player.key, player]));
  const control = Object.fromEntries(
    ["condition", "seed", "left", "right", "speed", "view", "time", "play", "clock"].map(
      (name) => [name, part(name)],
    ),
  );
  const sides = ["left", "right"].map((name) => {
    const figure = part(`${name}-stage`);
    return { name, figure, canvas: figure.querySelector("canvas"), film: null };
  });
  const state = { time: 0, end: 0, playing: false, last: 0, choice: 0, box: null, timer: 0 };
  const films = () => sides.map((side) => side.film).filter(Boolean);

  // ---------------------------------------------------------------- episodes

  const blocks = {};

  /** The episodes of a condition, parsed when they are first wanted. */
  function episodes(condition) {
    if (!blocks[condition]) {
      const all = [...document.querySelectorAll("script[data-condition]")];
      const found = all.find((script) => script.dataset.condition === condition);
      blocks[condition] = JSON.parse(found.textContent);
    }
    return blocks[condition];
  }

  /** What a player did in an episode, or null if it is not in the page. */
  function take(condition, seed, key) {
    const block = episodes(condition);
    return block.takes[key]?.[block.seeds.indexOf(seed)] ?? null;
  }

  async function inflate(text) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** The poses of a take as ``stage`` wants them; see ``pack`` in replay.py. */
  async function unpack({ poses: packed, frames }) {
    const bytes = await inflate(packed);
    const count = bytes.length / 2;
    const poses = new Float32Array(count);
    let step = 0;
    let value = 0;
    for (let k = 0; k < count; k += 1) {
      if (k % frames === 0) step = value = 0;
      const unsigned = bytes[k] | (bytes[count + k] << 8);
      step += (unsigned >>> 1) ^ -(unsigned & 1);
      value += step;
      poses[k] = value * world.units[Math.floor(k / frames) % 3];
    }
    return poses;
  }

  // ---------------------------------------------------------------- time

  function draw() {
    // One scale for both sides, also where their canvases differ by a pixel.
    const shown = sides.filter(({ film, canvas }) => film && canvas.clientWidth);
    const width = Math.min(...shown.map(({ canvas }) => canvas.clientWidth));
    const height = Math.min(...shown.map(({ canvas }) => canvas.clientHeight));
    for (const { film, canvas } of shown) {
      const eye = control.view.value === "near"
        ? stage.near(film, state.time, width, height)
        : stage.whole(state.box, width, height);
      stage.draw(canvas, film, state.time, eye);
    }
    control.time.value = state.time;
    control.clock.textContent = `${state.time.toFixed(1)} / ${state.end.toFixed(1)} s`;
  }

  function seek(time) {
    state.time = Math.min(Math.max(time, 0), state.end);
    draw();
  }

  function play(on) {
    if (on && state.time >= state.end) state.time = 0;
    state.playing = on && state.end > 0;
    state.last = performance.now();
    part("root").classList.toggle("playing", state.playing);
    control.play.setAttribute("aria-label", state.playing ? "Pause" : "Play");
    if (state.playing) requestAnimationFrame(advance);
    else remember();
  }

  function advance(now) {
    if (!state.playing) return;
    const elapsed = Math.max(0, now - state.last) / 1000;
    state.last = now;
    seek(state.time + elapsed * Number(control.speed.value));
    if (state.time >= state.end) play(false);
    else requestAnimationFrame(advance);
  }

  // ---------------------------------------------------------------- choice

  function options(select, labels, chosen) {
    select.replaceChildren(...labels.map(([value, label]) => new Option(label, value)));
    select.value = chosen;
  }

  /** The episodes of a condition, first those in which a policy failed that need not. */
  function listSeeds(chosen) {
    const condition = control.condition.value;
    const block = episodes(condition);
    const none = ["No policy", world.trivial.join(" and ")].filter(Boolean).join(" but ");
    const groups = [["A policy", true], [none, false]].map(([who, failed]) => {
      const group = document.createElement("optgroup");
      const seeds = block.seeds.filter((_, k) => block.failed[k] === failed);
      group.label = `${who} failed (${seeds.length})`;
      group.append(...seeds.map((seed) => new Option(told(condition, seed), seed)));
      return group;
    });
    control.seed.replaceChildren(...groups.filter((group) => group.children.length));
    control.seed.value = block.seeds.includes(chosen) ? chosen : block.seeds[0];
  }

  /** An episode and what became of it, policy by policy. */
  function told(condition, seed) {
    const marks = world.policies.map(({ name, keys }) => {
      const found = keys.map((key) => take(condition, seed, key)).filter(Boolean);
      const done = found.filter(({ success }) => success).length;
      if (keys.length > 1) return `${name} ${done}/${found.length}`;
      return found.length ? `${name} ${done ? "✓" : "✗"}` : "";
    });
    return [seed, ...marks.filter(Boolean)].join("  ");
  }

  /** The film that a side is to show, or null. */
  async function load(condition, seed, key) {
    const found = key === NONE ? null : take(condition, seed, key);
    if (!found) return null;
    return { condition: conditions[condition], player: players[key], take: found, poses: await unpack(found) };
  }

  /** Shows what the controls say, from a time on. */
  async function show(time) {
    const choice = (state.choice += 1);
    const [condition, seed] = [control.condition.value, Number(control.seed.value)];
    const loaded = await Promise.all(
      sides.map(({ name }) => load(condition, seed, control[name].value)),
    );
    if (choice !== state.choice) return; // another choice has been made meanwhile
    sides.forEach((side, k) => {
      side.film = loaded[k];
      label(side, seed);
    });
    part("root").querySelector(".stages").classList.toggle("single", control.right.value === NONE);
    state.end = Math.max(0, ...films().map(({ take }) => take.end));
    state.box = stage.bounds(films());
    control.time.max = state.end;
    drawLanes();
    seek(time);
  }

  function label({ name, figure, canvas, film }, seed) {
    const player = players[control[name].value];
    figure.hidden = !player;
    canvas.hidden = !film;
    if (!player) return;
    figure.querySelector(".swatch").style.setProperty("--colour", player.colour);
    figure.querySelector(".player").textContent = player.label;
    const outcome = figure.querySelector(".outcome");
    outcome.textContent = film ? film.take.outcome : "this episode is not in the page";
    outcome.className = `outcome ${film?.take.success ? "good" : "bad"}`;
    canvas.setAttribute("aria-label", `${player.label}, episode ${seed}: ${outcome.textContent}`);
  }

  function drawLanes() {
    const lanes = films().map(({ condition, take, player }) => {
      const lane = document.createElement("div");
      lane.className = "lane";
      lane.style.setProperty("--colour", player.colour);
      const bar = (kind, from, to) => {
        const span = document.createElement("span");
        span.className = kind;
        span.style.left = `${100 * from / state.end}%`;
        span.style.width = `${100 * (to - from) / state.end}%`;
        lane.append(span);
      };
      const held = condition.grasped ? 0 : take.closure ?? take.end;
      bar("before", 0, held);
      bar("after", held, take.end);
      return lane;
    });
    part("lanes").replaceChildren(...lanes);
  }

  // ---------------------------------------------------------------- address

  /** Puts the choice into the address, so that it can be shared; soon, for browsers mind often. */
  function remember() {
    clearTimeout(state.timer);
    state.timer = setTimeout(() => {
      const words = ["condition", "seed", "left", "right"].map((name) => [name, control[name].value]);
      words.push(["t", state.time.toFixed(1)]);
      if (control.view.value !== "all") words.push(["view", control.view.value]);
      history.replaceState(null, "", `#${new URLSearchParams(words)}`);
    }, PATIENCE);
  }

  /** Sets the controls as the address says; whether it says anything of the replay. */
  async function recall() {
    const words = new URLSearchParams(location.hash.slice(1));
    const chosen = words.has("condition");
    for (const name of ["condition", "left", "right", "view"]) {
      const values = [...control[name].options].map(({ value }) => value);
      if (values.includes(words.get(name))) control[name].value = words.get(name);
    }
    listSeeds(Number(words.get("seed")));
    await show(Number(words.get("t")) || 0);
    return chosen;
  }

  async function choose() {
    play(false);
    await show(0);
    remember();
  }

  function stepSeed(step) {
    const { seed } = control;
    seed.selectedIndex = (seed.selectedIndex + step + seed.length) % seed.length;
    choose();
  }

  // ---------------------------------------------------------------- events

  function pressed(event) {
    const { key, target, shiftKey } = event;
    if (target.tagName === "SELECT" || event.ctrlKey || event.metaKey || event.altKey) return;
    const move = { ArrowLeft: -1, ArrowRight: 1 }[key];
    if (key === " " && target.tagName !== "BUTTON") play(!state.playing);
    else if (move) seek(state.time + move * (shiftKey ? 10 : 1));
    else if (key === "Home") seek(0);
    else if (key === "End") seek(state.end);
    else return;
    event.preventDefault();
    if (!state.playing) remember();
  }

  /** Goes to what the address says, if it says anything of the replay. */
  async function follow() {
    if (await recall()) part("root").scrollIntoView();
  }

  function fill() {
    const labels = world.players.map(({ key, label }) => [key, label]);
    const about = world.conditions.map((condition) => [condition.name, [condition.name, condition.about].filter(Boolean)]);
    options(control.condition, about.map(([name, words]) => [name, words.join(": ")]), about[0][0]);
    options(control.left, labels, labels[0][0]);
    options(control.right, [...labels, [NONE, "none"]], labels[1]?.[0] ?? NONE);
    part("root").hidden = false;
  }

  const redraw = () => state.box && draw();

  /** Draws anew when pixels get finer or coarser, as on another screen. */
  function watchPixels() {
    const same = matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`);
    same.addEventListener("change", () => { redraw(); watchPixels(); }, { once: true });
  }

  function listen() {
    control.condition.addEventListener("change", () => listSeeds(Number(control.seed.value)));
    for (const name of ["condition", "seed", "left", "right"]) {
      control[name].addEventListener("change", choose);
    }
    control.view.addEventListener("change", () => seek(state.time));
    control.view.addEventListener("change", remember);
    control.time.addEventListener("input", () => seek(Number(control.time.value)));
    control.time.addEventListener("change", remember);
    part("previous").addEventListener("click", () => stepSeed(-1));
    part("next").addEventListener("click", () => stepSeed(1));
    part("root").addEventListener("keydown", pressed);
    const resized = new ResizeObserver(redraw);
    for (const { canvas } of sides) resized.observe(canvas);
    watchPixels();
    for (const shown of [control.play, ...sides.map(({ canvas }) => canvas)]) {
      shown.addEventListener("click", () => play(!state.playing));
    }
    window.addEventListener("hashchange", () => {
      if (!location.hash.includes("condition=")) return;
      play(false);
      follow();
    });
  }

  if (world.conditions.some(({ embedded }) => embedded)) {
    fill();
    listen();
    follow();
  }
})();
