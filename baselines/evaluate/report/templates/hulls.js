// Hulls and the goal, drawn in metres with y upwards; px is the size of a pixel, m.
const hulls = ((palette) => {
  const { line, fill, stroke } = paint;
  const CHEVRON = [[0.9, 0], [-0.5, 0.8], [-0.15, 0], [-0.5, -0.8]];

  /** Runs a drawing in the frame of a hull, with its outline as the current path. */
  function inside(pen, outline, [x, y, heading], drawing) {
    pen.save();
    pen.translate(x, y);
    pen.rotate(heading);
    line(pen, outline);
    pen.closePath();
    drawing();
    pen.restore();
  }

  /** An arrow head that points ahead, where most of the vessel is round a point. */
  function chevron(pen, [x, y, room], colour, alpha) {
    const scale = 0.6 * room;
    line(pen, CHEVRON.map(([u, v]) => [x + scale * u, y + scale * v]));
    fill(pen, colour, alpha);
  }

  function shadow(pen, outline, [x, y, heading], px) {
    const below = [x + 1.5 * px, y - 2.2 * px, heading];
    inside(pen, outline, below, () => fill(pen, palette.shadow));
  }

  function drawVessel(pen, condition, pose, px) {
    shadow(pen, condition.vessel, pose, px);
    inside(pen, condition.vessel, pose, () => {
      fill(pen, palette.deck);
      stroke(pen, palette.keel, 1.6 * px);
      chevron(pen, condition.middle, palette.keel);
    });
  }

  /** The area of the goal, below the vessel. */
  function drawGoal(pen, condition, goal) {
    inside(pen, condition.vessel, goal, () => {
      fill(pen, palette.white, 0.17);
      chevron(pen, condition.middle, palette.white, 0.6);
    });
  }

  /** The dashed outline of the goal, above the vessel. */
  function outlineGoal(pen, condition, goal, px) {
    inside(pen, condition.vessel, goal, () => {
      pen.setLineDash([7 * px, 5 * px]);
      stroke(pen, palette.edge, 3.4 * px);
      stroke(pen, palette.white, 2 * px);
    });
  }

  function drawBoat(pen, { condition, take }, boat, pose, time, px) {
    const failure = take.failures[boat];
    const works = failure === null || time < failure;
    const size = take.sizes[boat];
    const outline = condition.boat.map(([x, y]) => [size * x, size * y]);
    const bow = Math.max(...outline.map(([x]) => x));
    shadow(pen, outline, pose, 0.7 * px);
    inside(pen, outline, pose, () => {
      fill(pen, works ? palette.team[boat % palette.team.length] : palette.failed);
      pen.save();
      pen.clip();
      pen.fillStyle = palette.white;
      pen.globalAlpha = works ? 1 : 0.5;
      pen.fillRect(bow - size * condition.bow, -bow, size * condition.bow, 2 * bow);
      pen.restore();
      stroke(pen, palette.edge, Math.min(1.2 * px, 0.1 * bow));
      if (!works) cross(pen, 0.7 * Math.max(...outline.map(([, y]) => Math.abs(y))), px);
    });
  }

  /** The mark of a boat whose thrusters have failed. */
  function cross(pen, size, px) {
    pen.beginPath();
    for (const sign of [-1, 1]) {
      pen.moveTo(-size, -sign * size);
      pen.lineTo(size, sign * size);
    }
    stroke(pen, palette.mark, Math.max(1.5 * px, 0.28 * size));
  }

  /** Stones: polygons are lists of corners, others one row with both ends and the radius. */
  function drawObstacles(pen, obstacles, px) {
    const shape = (rows) => {
      if (rows.length > 1) {
        line(pen, rows);
      } else {
        const [[ax, ay, bx, by, radius]] = rows;
        const turn = Math.atan2(by - ay, bx - ax);
        pen.beginPath();
        pen.arc(bx, by, radius, turn - Math.PI / 2, turn + Math.PI / 2);
        pen.arc(ax, ay, radius, turn + Math.PI / 2, turn + 1.5 * Math.PI);
      }
      pen.closePath();
    };
    const all = (drawing) => obstacles.forEach((rows) => { shape(rows); drawing(); });
    pen.save();
    pen.translate(1.5 * px, -2.2 * px);
    all(() => fill(pen, palette.shadow));
    pen.restore();
    all(() => stroke(pen, palette.stone_edge, 3 * px));
    all(() => fill(pen, palette.stone)); // Obstacles that overlap are one to the eye.
  }

  return { drawVessel, drawGoal, outlineGoal, drawBoat, drawObstacles };
})(world.palette);
