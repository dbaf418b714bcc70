// Applies a linear map, given by its columns, to a vector.
const apply = (columns, v) => [0, 1, 2].map((row) => columns[0][row] * v[0] + columns[1][row] * v[1] + columns[2][row] * v[2]);

// Multiplies the rotation by an angle (rad) round an axis of unit length with a quaternion.
function rotated([x, y, z, w], axis, angle) {
  const [s, c] = [Math.sin(angle / 2), Math.cos(angle / 2)];
  const [a, b, d] = axis.map((value) => value * s);
  return [
    c * x + a * w + b * z - d * y,
    c * y - a * z + b * w + d * x,
    c * z + a * y - b * x + d * w,
    c * w - a * x - b * y - d * z,
  ];
}

// Object that is moved: a node of the file with its own transform.
class EditedNode {
  // Takes the description of a node by the server.
  constructor({ index, name, translation, rotation, scale, position, to_parent }) {
    Object.assign(this, { index, name, translation, rotation, scale, position, toParent: to_parent });
  }

  // Moves the object by a vector of the world (m).
  move(by) {
    this.translation = add(this.translation, apply(this.toParent, by));
    this.position = add(this.position, by);
  }

  // Turns the object round the vertical (rad).
  turn(angle) {
    this.rotation = rotated(this.rotation, unit(apply(this.toParent, [0, 1, 0])), angle);
  }

  // Moves the object by shares of the image's height, at its own depth.
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
