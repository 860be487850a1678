// The replay: shows the chosen episode of two players side by side, at the same time and scale.
(() => {
  const PATIENCE = 250; // ms before the address is changed
  const { NONE, CHOSEN, part, players, control } = choice;
  const sides = ["left", "right"].map((name) => {
    const figure = part(`${name}-stage`);
    return { name, figure, canvas: figure.querySelector("canvas"), film: null };
  });
  const state = { time: 0, end: 0, playing: false, last: 0, request: 0, box: null, timer: 0 };
  const films = () => sides.map((side) => side.film).filter(Boolean);

  function draw() {
    // One scale for both sides, even where their canvases differ by a pixel.
    const shown = sides.filter(({ film, canvas }) => film && canvas.clientWidth);
    const width = Math.min(...shown.map(({ canvas }) => canvas.clientWidth));
    const height = Math.min(...shown.map(({ canvas }) => canvas.clientHeight));
    for (const { film, canvas } of shown) {
      const view = control.view.value === "near"
        ? camera.near(film, state.time, width, height)
        : camera.whole(state.box, width, height);
      stage.draw(canvas, film, state.time, view);
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
    else writeAddress();
  }

  function advance(now) {
    if (!state.playing) return;
    const elapsed = Math.max(0, now - state.last) / 1000;
    state.last = now;
    seek(state.time + elapsed * Number(control.speed.value));
    if (state.time >= state.end) play(false);
    else requestAnimationFrame(advance);
  }

  /** Shows what the controls have chosen, from a time on. */
  async function show(time) {
    const request = (state.request += 1);
    const loaded = await Promise.all(sides.map(({ name }) => choice.film(name)));
    if (request !== state.request) return; // something else has been chosen meanwhile
    sides.forEach((side, k) => {
      side.film = loaded[k];
      label(side);
    });
    part("root").querySelector(".stages").classList.toggle("single", control.right.value === NONE);
    state.end = Math.max(0, ...films().map(({ take }) => take.end));
    state.box = camera.bounds(films());
    control.time.max = state.end;
    part("lanes").replaceChildren(...films().map(lane));
    seek(time);
  }

  function label({ name, figure, canvas, film }) {
    const player = players[control[name].value];
    figure.hidden = !player;
    canvas.hidden = !film;
    if (!player) return;
    figure.querySelector(".swatch").style.setProperty("--colour", player.colour);
    figure.querySelector(".player").textContent = player.label;
    const outcome = figure.querySelector(".outcome");
    outcome.textContent = film ? film.take.outcome : "this episode is not in the page";
    outcome.className = `outcome ${film?.take.success ? "good" : "bad"}`;
    const title = `${player.label}, episode ${control.seed.value}: ${outcome.textContent}`;
    canvas.setAttribute("aria-label", title);
  }

  /** A bar below the time line: pale before closure, solid until the end of the episode. */
  function lane({ condition, take, player }) {
    const closure = condition.grasped ? 0 : take.closure ?? take.end;
    const bar = (kind, from, to) => `<span class="${kind}" style="left:
      ${100 * from / state.end}%; width: ${100 * (to - from) / state.end}%"></span>`;
    const element = document.createElement("div");
    element.className = "lane";
    element.style.setProperty("--colour", player.colour);
    element.innerHTML = bar("before", 0, closure) + bar("after", closure, take.end);
    return element;
  }

  async function choose() {
    play(false);
    await show(0);
    writeAddress();
  }

  function stepSeed(step) {
    const { seed } = control;
    seed.selectedIndex = (seed.selectedIndex + step + seed.length) % seed.length;
    choose();
  }

  /** Writes the choice into the address, to be shared; with a delay, as browsers limit changes. */
  function writeAddress() {
    clearTimeout(state.timer);
    state.timer = setTimeout(() => {
      const words = CHOSEN.map((name) => [name, control[name].value]);
      words.push(["t", state.time.toFixed(1)]);
      if (control.view.value !== "all") words.push(["view", control.view.value]);
      history.replaceState(null, "", `#${new URLSearchParams(words)}`);
    }, PATIENCE);
  }

  /** Shows what the address names, and scrolls to the replay if it names anything of it. */
  async function readAddress() {
    const words = new URLSearchParams(location.hash.slice(1));
    for (const name of ["condition", "left", "right", "view"]) {
      const values = [...control[name].options].map(({ value }) => value);
      if (values.includes(words.get(name))) control[name].value = words.get(name);
    }
    choice.fillSeeds(Number(words.get("seed")));
    await show(Number(words.get("t")) || 0);
    if (words.has("condition")) part("root").scrollIntoView();
  }

  function pressed(event) {
    const { key, target, shiftKey } = event;
    if (target.tagName === "SELECT" || event.ctrlKey || event.metaKey || event.altKey) return;
    const direction = { ArrowLeft: -1, ArrowRight: 1 }[key];
    if (key === " " && target.tagName !== "BUTTON") play(!state.playing);
    else if (direction) seek(state.time + direction * (shiftKey ? 10 : 1));
    else if (key === "Home") seek(0);
    else if (key === "End") seek(state.end);
    else return;
    event.preventDefault();
    if (!state.playing) writeAddress();
  }

  const redraw = () => state.box && draw();

  /** Draws again when the density of pixels changes, as on another screen. */
  function watchDensity() {
    const same = matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`);
    same.addEventListener("change", () => { redraw(); watchDensity(); }, { once: true });
  }

  function listen() {
    const on = (element, type, action) => element.addEventListener(type, action);
    on(control.condition, "change", () => choice.fillSeeds(Number(control.seed.value)));
    CHOSEN.forEach((name) => on(control[name], "change", choose));
    on(control.view, "change", () => { seek(state.time); writeAddress(); });
    on(control.time, "input", () => seek(Number(control.time.value)));
    on(control.time, "change", writeAddress);
    on(part("previous"), "click", () => stepSeed(-1));
    on(part("next"), "click", () => stepSeed(1));
    on(part("root"), "keydown", pressed);
    const toggles = [control.play, ...sides.map(({ canvas }) => canvas)];
    toggles.forEach((each) => on(each, "click", () => play(!state.playing)));
    on(window, "hashchange", () => {
      if (!location.hash.includes("condition=")) return;
      play(false);
      readAddress();
    });
    const resized = new ResizeObserver(redraw);
    sides.forEach(({ canvas }) => resized.observe(canvas));
    watchDensity();
  }

  const able = "DecompressionStream" in window;
  part("needs").hidden = able;
  if (able && world.conditions.some(({ embedded }) => embedded)) {
    choice.fill();
    part("root").hidden = false;
    listen();
    readAddress();
  }
})();
