// The stage: draws one moment of a film to scale.
const stage = ((palette) => {
  const { line, stroke } = paint;
  const FONT = '500 12px system-ui, -apple-system, "Segoe UI", Roboto, Arial, sans-serif';
  const BANDS = 16; // of different opacity in a trail
  const FRESH = 20; // s for which a trail hardly fades

  /** Draws a film at a time, as a camera sees it. */
  function draw(canvas, film, time, view) {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const density = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * density);
    canvas.height = Math.round(height * density);
    const pen = canvas.getContext("2d");
    const inPixels = () => pen.setTransform(density, 0, 0, density, 0, 0);
    inPixels();
    drawWater(pen, width, height);
    const m = density * view.scale; // metres from here on, y upwards
    const [left, top] = [density * width / 2 - m * view.x, density * height / 2 + m * view.y];
    pen.setTransform(m, 0, 0, -m, left, top);
    const px = 1 / view.scale;
    const spacing = roundNumber(width / 4.5 * px);
    drawGrid(pen, view, width, height, spacing, px);
    drawWorld(pen, film, time, px);
    inPixels();
    drawCaptions(pen, film, time, width);
    drawScale(pen, height, spacing, view.scale);
  }

  /** The largest of 1, 2, 5 times a power of ten that is at most a limit. */
  function roundNumber(limit) {
    const decade = 10 ** Math.floor(Math.log10(limit));
    return [5, 2, 1].map((k) => k * decade).find((number) => number <= limit);
  }

  function drawWater(pen, width, height) {
    const water = pen.createLinearGradient(0, 0, 0, height);
    water.addColorStop(0, palette.water_top);
    water.addColorStop(1, palette.water_bottom);
    pen.fillStyle = water;
    pen.fillRect(0, 0, width, height);
  }

  function drawGrid(pen, view, width, height, spacing, px) {
    const [west, east] = [view.x - width / 2 * px, view.x + width / 2 * px];
    const [south, north] = [view.y - height / 2 * px, view.y + height / 2 * px];
    const lines = (from, to, add) => {
      for (let k = Math.ceil(from / spacing) * spacing; k < to; k += spacing) add(k);
    };
    pen.beginPath();
    lines(west, east, (x) => { pen.moveTo(x, south); pen.lineTo(x, north); });
    lines(south, north, (y) => { pen.moveTo(west, y); pen.lineTo(east, y); });
    stroke(pen, palette.white, px, 0.09);
  }

  function drawWorld(pen, film, time, px) {
    const { condition } = film;
    if (condition.walls !== null) {
      pen.beginPath();
      pen.rect(-condition.walls, -condition.walls, 2 * condition.walls, 2 * condition.walls);
      stroke(pen, palette.quay, 4 * px);
    }
    hulls.drawObstacles(pen, film.take.obstacles, px);
    const goal = goalOf(film, time);
    if (goal) hulls.drawGoal(pen, condition, goal);
    drawTrail(pen, film, time, px);
    hulls.drawVessel(pen, condition, poses.at(film, 0, time), px);
    if (goal) hulls.outlineGoal(pen, condition, goal, px);
    for (let boat = 0; boat < condition.boats; boat += 1) {
      hulls.drawBoat(pen, film, boat, poses.at(film, boat + 1, time), time, px);
    }
  }

  /** The goal, once it is known: one that is anchored at closure exists from closure on. */
  function goalOf({ condition, take }, time) {
    if (!condition.anchored) return take.goal;
    return take.closure !== null && time >= take.closure ? take.goal : null;
  }

  /** The path of the vessel so far, fading in bands, in a pale shade of the policy's colour. */
  function drawTrail(pen, film, time, px) {
    const { condition, take, player } = film;
    const now = Math.min(time, take.end);
    const points = poses.path(film, now);
    const length = Math.max(1, Math.ceil(points.length / BANDS));
    const colour = `color-mix(in srgb, ${player.colour}, white 55%)`;
    pen.lineJoin = "round";
    for (let first = 0; first < points.length - 1; first += length) {
      const age = (now - first * condition.step) / Math.max(now, FRESH);
      line(pen, points.slice(first, first + length + 1));
      stroke(pen, colour, 3 * px, 1 - 0.75 * Math.max(0, Math.min(1, age)));
    }
  }

  function write(pen, text, x, y, align, colour) {
    Object.assign(pen, { font: FONT, textBaseline: "middle", textAlign: align });
    Object.assign(pen, { strokeStyle: palette.edge, lineWidth: 3, lineJoin: "round" });
    pen.globalAlpha = 0.55;
    pen.strokeText(text, x, y);
    Object.assign(pen, { fillStyle: colour, globalAlpha: 1 });
    pen.fillText(text, x, y);
  }

  function drawCaptions(pen, film, time, width) {
    const { take } = film;
    const colour = time >= take.end && take.success ? palette.good : palette.ink;
    write(pen, phase(film, time), 14, 18, "left", colour);
    write(pen, `${Math.min(time, take.end).toFixed(1)} s`, width - 14, 18, "right", palette.ink);
  }

  /** A bar with its length in metres. */
  function drawScale(pen, height, length, scale) {
    const [left, right, y] = [14, 14 + length * scale, height - 18];
    line(pen, [[left, y - 5], [left, y], [right, y], [right, y - 5]]);
    stroke(pen, palette.ink, 2);
    write(pen, `${Number(length.toPrecision(1))} m`, right + 8, y - 1, "left", palette.ink);
  }

  /** Whether the vessel is, or was, in closure, in a few words. */
  function phase({ condition, take }, time) {
    if (time >= take.end) return take.verdict;
    if (condition.grasped) return "closed from the start";
    if (take.closure === null || time < take.closure) return "not closed yet";
    return `closed at ${take.closure.toFixed(1)} s`;
  }

  return { draw };
})(world.palette);
