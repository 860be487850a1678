// Lines, areas and their colours on a canvas; every area and line sets its own opacity, alpha.
const paint = {
  /** Makes a line through points the current path. */
  line(pen, points) {
    pen.beginPath();
    points.forEach(([x, y]) => pen.lineTo(x, y));
  },
  fill(pen, fillStyle, alpha = 1) {
    Object.assign(pen, { fillStyle, globalAlpha: alpha });
    pen.fill();
  },
  stroke(pen, strokeStyle, lineWidth, alpha = 1) {
    Object.assign(pen, { strokeStyle, lineWidth, globalAlpha: alpha });
    pen.stroke();
  },
};
