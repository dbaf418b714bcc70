// An object that is moved: a node of the file, by its own translation and rotation.
const apply = (columns, v) => [0, 1, 2].map((row) => columns[0][row] * v[0] + columns[1][row] * v[1] + columns[2][row] * v[2]);

// The rotation by an angle (rad) round an axis of unit length, and then by another quaternion before it.
function turned([x, y, z, w], axis, angle) {
  const [s, c] = [Math.sin(angle / 2), Math.cos(angle / 2)];
  const [a, b, d] = axis.map((value) => value * s);
  return [
    c * x + a * w + b * z - d * y,
    c * y - a * z + b * w + d * x,
    c * z + a * y - b * x + d * w,
    c * w - a * x - b * y - d * z,
  ];
}

class Thing {
  // What the server says of a node.
  constructor({ index, name, translation, rotation, scale, position, to_parent }) {
    Object.assign(this, { index, name, translation, rotation, scale, position, toParent: to_parent });
  }

  // Moves it by a way in the world (m).
  move(by) {
    this.translation = add(this.translation, apply(this.toParent, by));
    this.position = add(this.position, by);
  }

  // Turns it round the vertical (rad).
  turn(angle) {
    this.rotation = turned(this.rotation, unit(apply(this.toParent, [0, 1, 0])), angle);
  }

  // Moves it as it is dragged by shares of the image's height, at its own distance from the eye.
  drag(camera, x, y) {
    const { forward, right, up } = camera.axes();
    const depth = Math.max(1e-6, dot(add(this.position, camera.from, -1), forward));
    const height = 2 * depth * Math.tan((camera.fov * Math.PI) / 360);
    this.move(add(right.map((value) => value * x * height), up, -y * height));
  }

  get message() {
    const { index, translation, rotation, scale } = this;
    return { do: 'place', node: index, translation, rotation, scale };
  }
}
