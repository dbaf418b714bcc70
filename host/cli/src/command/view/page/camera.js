// Camera: position of the eye, position that it looks at, and vertical field of view. Metres and degrees, y upwards.
const add = (a, b, scale = 1) => a.map((value, i) => value + scale * b[i]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const length = (a) => Math.hypot(...a);
const unit = (a) => a.map((value) => value / (length(a) || 1));

const MAX_ELEVATION = (89.5 * Math.PI) / 180; // At 90 degrees right and left are undefined.

class Camera {
  constructor(from, lookAt, fov) {
    Object.assign(this, { from, lookAt, fov });
  }

  // Makes the camera of a status; it looks at the position at this distance.
  static from({ from, forward, fov }, distance) {
    return new Camera(from, add(from, forward, distance), fov);
  }

  get distance() {
    return length(add(this.lookAt, this.from, -1));
  }

  axes() {
    const forward = unit(add(this.lookAt, this.from, -1));
    const level = cross(forward, [0, 1, 0]);
    const right = length(level) > 1e-6 ? unit(level) : [1, 0, 0];
    return { forward, right, up: cross(right, forward) };
  }

  // Turns a direction by an azimuth round the vertical and an elevation (rad).
  turned(azimuth, elevation, direction) {
    const around = Math.atan2(direction[0], direction[2]) + azimuth;
    const up = Math.asin(Math.max(-1, Math.min(1, direction[1]))) + elevation;
    const clamped = Math.max(-MAX_ELEVATION, Math.min(MAX_ELEVATION, up));
    const level = Math.cos(clamped);
    return [level * Math.sin(around), Math.sin(clamped), level * Math.cos(around)];
  }

  orbit(azimuth, elevation) {
    const { forward } = this.axes();
    const direction = this.turned(azimuth, elevation, forward.map((value) => -value));
    this.from = add(this.lookAt, direction, this.distance);
  }

  // Turns the view; the eye stays.
  look(azimuth, elevation) {
    this.lookAt = add(this.from, this.turned(azimuth, elevation, this.axes().forward), this.distance);
  }

  // Moves by shares of the image's height at the distance of the position that it looks at.
  pan(x, y) {
    const { right, up } = this.axes();
    const height = 2 * this.distance * Math.tan((this.fov * Math.PI) / 360);
    this.move(add(right.map((value) => value * x * height), up, y * height));
  }

  move(by) {
    this.from = add(this.from, by);
    this.lookAt = add(this.lookAt, by);
  }

  dolly(factor) {
    const { forward } = this.axes();
    this.from = add(this.lookAt, forward, -Math.max(1e-6, this.distance * factor));
  }

  // Projects a position of the world into the image, in shares of its width and height; null behind the eye.
  project(position, aspect) {
    const { forward, right, up } = this.axes();
    const to = add(position, this.from, -1);
    const depth = dot(to, forward);
    if (depth <= 1e-9) return null;
    const tangent = Math.tan((this.fov * Math.PI) / 360);
    return [0.5 + dot(to, right) / (2 * depth * tangent * aspect), 0.5 - dot(to, up) / (2 * depth * tangent)];
  }
}
