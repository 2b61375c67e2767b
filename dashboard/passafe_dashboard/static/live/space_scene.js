// The live scene of a robot in space, seen from two sides: links, spheres that cover it, balls and levels to keep off.

import { Camera } from "./camera.js";
import { CORNER_PX, LiveCanvas } from "./live_canvas.js";
import { ShownLook } from "./shown_look.js";

/** @typedef {import("./types.js").Now} Now
 * @typedef {import("./types.js").Pair} Pair
 * @typedef {import("./types.js").Spot} Spot */

/** A view: its title and the two coordinates that it shows, right and up.
 * @typedef {{title: string, axes: Pair}} View */

/** @type {View[]} */
const VIEWS = [
  { title: "from the side", axes: [0, 2] },
  { title: "from above", axes: [0, 1] },
];
const MOST_TRAIL = 400;
const JOINT_PX = 5;
const LINK_PX = 6;

/** Returns a spot as a view shows it.
 * @param {Spot} spot
 * @param {Pair} axes
 * @returns {Pair} */
export function seen(spot, axes) {
  return [spot[axes[0]], spot[axes[1]]];
}

export class SpaceScene {
  /** @param {HTMLCanvasElement} ground
   * @param {HTMLCanvasElement} canvas
   * @param {import("./types.js").Space} scene */
  constructor(ground, canvas, scene) {
    this.canvas = new LiveCanvas(canvas);
    this.look = new ShownLook();
    this.scene = scene;
    ground.hidden = true;
    document.querySelector(".scene .key")?.toggleAttribute("hidden", true);
    /** @type {Spot[]} */
    this.trail = [];
    this.cameras = VIEWS.map(({ axes }) => new Camera([seen(scene.bounds[0], axes), seen(scene.bounds[1], axes)]));
  }

  /** @param {Now} now
   * @param {any} theme */
  draw(now, theme) {
    const { width, height } = this.canvas;
    if (!width || !height) return;
    const body = now.plant?.body;
    if (body) this.follow(body.points[body.points.length - 1]);
    /** @type {Spot[]} */
    const points = body?.points ?? [];
    const beside = width > height;
    const size = beside ? [width / 2, height] : [width, height / 2];
    VIEWS.forEach(({ axes }, i) => this.cameras[i].aim(size[0], size[1], points.map((point) => seen(point, axes))));
    if (!this.look.isNew(this.lookOf(body), [...this.canvas.frame, theme, now.liveness.state])) return;
    const pen = this.canvas.clear();
    pen.save();
    pen.beginPath();
    pen.roundRect(0, 0, width, height, CORNER_PX);
    pen.clip();
    VIEWS.forEach((view, i) => {
      pen.save();
      pen.translate(beside ? i * size[0] : 0, beside ? 0 : i * size[1]);
      pen.beginPath();
      pen.rect(0, 0, size[0], size[1]);
      pen.clip();
      this.drawView(pen, view, this.cameras[i], body, theme, now.liveness.state !== "live");
      pen.restore();
    });
    pen.fillStyle = theme.line;
    pen.fillRect(beside ? size[0] : 0, beside ? 0 : size[1], beside ? 1 : width, beside ? height : 1);
    pen.restore();
  }

  /** Returns the numbers of which the picture depends, pixels.
   * @param {import("./types.js").Body | undefined} body
   * @returns {number[]} */
  lookOf(body) {
    const spots = [...(body?.points ?? []), ...(body?.spheres ?? [])];
    const seenBy = this.cameras.map((camera, i) => {
      return [...camera.pixel(0, 0), 100 * Math.log(camera.scale), ...spots.flatMap((spot) => camera.pixel(...seen(spot, VIEWS[i].axes)))];
    });
    return seenBy.flat();
  }

  /** @param {Spot} tip */
  follow(tip) {
    const last = this.trail[this.trail.length - 1];
    if (last && Math.hypot(tip[0] - last[0], tip[1] - last[1], tip[2] - last[2]) < 0.002) return;
    this.trail.push(tip);
    if (this.trail.length > MOST_TRAIL) this.trail.shift();
  }

  /** @param {CanvasRenderingContext2D} pen
   * @param {View} view
   * @param {Camera} camera
   * @param {import("./types.js").Body | undefined} body
   * @param {any} theme
   * @param {boolean} old */
  drawView(pen, { title, axes }, camera, body, theme, old) {
    /** @param {Spot} spot */
    const pixel = (spot) => camera.pixel(...seen(spot, axes));
    if (axes[1] === 2) this.drawLevels(pen, camera, theme);
    for (const { name, centre, radius } of this.scene.balls) {
      disk(pen, pixel(centre), radius * camera.scale, theme["unsafe-wash"], theme.unsafe, 2);
      text(pen, name, pixel(centre), theme.ink, "center");
    }
    text(pen, title, [12, 16], theme.quiet, "left");
    if (!body) return;
    strip(pen, this.trail.map(pixel), theme.lines[0], 1.5, 0.5);
    const colour = old ? theme.quiet : theme.lines[0];
    pen.globalAlpha = 0.16;
    body.spheres.forEach((centre, i) => disk(pen, pixel(centre), this.scene.radii[i] * camera.scale, colour, colour, 1));
    pen.globalAlpha = 1;
    for (const [from, to] of this.scene.links) strip(pen, [pixel(body.points[from]), pixel(body.points[to])], colour, LINK_PX, 1);
    body.points.forEach((point, i) => {
      const isTip = i === body.points.length - 1;
      disk(pen, pixel(point), isTip ? JOINT_PX + 2 : JOINT_PX, isTip ? colour : theme.raised, isTip ? theme.raised : colour, 2);
    });
  }

  /** @param {CanvasRenderingContext2D} pen
   * @param {Camera} camera
   * @param {any} theme */
  drawLevels(pen, camera, theme) {
    for (const { name, height_m } of this.scene.levels) {
      const [, row] = camera.pixel(0, height_m);
      pen.fillStyle = theme["unsafe-wash"];
      pen.fillRect(0, row, camera.width, camera.height - row);
      pen.fillStyle = theme.unsafe;
      pen.fillRect(0, row - 1, camera.width, 2);
      text(pen, name, [camera.width - 12, row + 14], theme.ink, "right");
    }
  }
}

/** @param {CanvasRenderingContext2D} pen
 * @param {Pair} centre
 * @param {number} radius
 * @param {string} fill
 * @param {string} edge
 * @param {number} width */
function disk(pen, centre, radius, fill, edge, width) {
  pen.beginPath();
  pen.arc(centre[0], centre[1], radius, 0, 2 * Math.PI);
  pen.fillStyle = fill;
  pen.fill();
  pen.lineWidth = width;
  pen.strokeStyle = edge;
  pen.stroke();
}

/** @param {CanvasRenderingContext2D} pen
 * @param {Pair[]} places
 * @param {string} colour
 * @param {number} width
 * @param {number} alpha */
function strip(pen, places, colour, width, alpha) {
  if (places.length < 2) return;
  pen.globalAlpha = alpha;
  pen.beginPath();
  for (const place of places) pen.lineTo(...place);
  pen.lineWidth = width;
  pen.lineCap = "round";
  pen.strokeStyle = colour;
  pen.stroke();
  pen.globalAlpha = 1;
}

/** @param {CanvasRenderingContext2D} pen
 * @param {string} words
 * @param {Pair} place
 * @param {string} colour
 * @param {CanvasTextAlign} align */
function text(pen, words, place, colour, align) {
  pen.font = "12px system-ui, sans-serif";
  pen.textAlign = align;
  pen.textBaseline = "middle";
  pen.fillStyle = colour;
  pen.fillText(words, place[0], place[1]);
}
