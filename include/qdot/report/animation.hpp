#pragma once
// SPDX-License-Identifier: MIT
//
// A moving picture as plain data: points that move, and shapes that hang on them.
//
// Every frame is a list of points in the plane or in space, always equally many; a shape names points by their index in the frame.
// So a double pendulum is three points (pivot, two bobs), one line through them, two disks and the trail of the last:
//
//     Drawing{.shapes = {line({0, 1, 2}), pivot(0), disk(1), disk(2), trail(2)}}
//
// A drawing in space has a camera, in_space({line({0, 1}), disk(1)}), and z of its points is upwards. It is seen in parallel projection, in which
// a circle is an ellipse and z stays upright; the reader of a page turns it.

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace qdot::report {

/// A point of the picture, in the units of the model; y is upwards, or in space z.
struct Point {
  double x = 0;  ///< to the right
  double y = 0;  ///< upwards; in space away from an observer that looks along y
  double z = 0;  ///< of pictures in space: upwards
};

/// From where a picture in space is seen at first.
struct Camera {
  double side = 25;   ///< degrees to the right of the y axis' back
  double above = 20;  ///< degrees above the plane of x and y
};

/// Something to draw; what `points` and `size` mean depends on the kind.
struct Shape {
  /// What it looks like.
  enum class Kind {
    line,     ///< through the points: a rod, a string, a chain
    spring,   ///< a coil between two points
    disk,     ///< a bob at one point; size is its radius in pixels
    trail,    ///< the path of one point so far; size is how long it lasts, in units of time (0: for ever)
    pivot,    ///< a small fixed bearing at one point
    box,      ///< an upright rectangle around one point; size is its width, size2 its height, in the units of the model
    ellipse,  ///< the image of a circle: centre and the ends of two conjugate radii
    arrow,    ///< from one point to another: a force, a velocity; nothing where they are the same
  };
  Kind kind = Kind::line;   ///< what it looks like
  std::vector<int> points;  ///< their numbers among the points of a frame
  double size = 0;          ///< as the kind has it
  double size2 = 0;         ///< as the kind has it
  int colour = -1;          ///< a series colour, or −1 for ink
};

/// A line through points: a rod, a string, a chain.
inline Shape line(std::vector<int> points, int colour = -1) { return {Shape::Kind::line, std::move(points), 0, 0, colour}; }
/// A coil between two points.
inline Shape spring(int from, int to) { return {Shape::Kind::spring, {from, to}, 0, 0, -1}; }
/// A bob.
inline Shape disk(int point, int colour = 0, double radius_px = 9) {
  return {Shape::Kind::disk, {point}, radius_px, 0, colour};
}
/// The path of a point so far.
inline Shape trail(int point, int colour = 0, double lasts = 0) {
  return {Shape::Kind::trail, {point}, lasts, 0, colour};
}
/// A fixed bearing.
inline Shape pivot(int point) { return {Shape::Kind::pivot, {point}, 0, 0, -1}; }
/// An upright rectangle around a point, in the units of the model.
inline Shape box(int point, double width, double height, int colour = -1) {
  return {Shape::Kind::box, {point}, width, height, colour};
}
/// The image of a circle.
inline Shape ellipse(int centre, int end_of_first_radius, int end_of_second_radius, int colour = -1) {
  return {Shape::Kind::ellipse, {centre, end_of_first_radius, end_of_second_radius}, 0, 0, colour};
}

/// An arrow between two points.
inline Shape arrow(int from, int to, int colour = 1) { return {Shape::Kind::arrow, {from, to}, 0, 0, colour}; }

/// What is drawn of a scene: shapes on its moving points, and lines that never move (ground, rail, wall).
struct Drawing {
  std::vector<Shape> shapes{};                 ///< one over the other
  std::vector<std::vector<Point>> backdrop{};  ///< lines behind them
  std::optional<Camera> camera{};              ///< of a picture in space; none for one in the plane, where z is not looked at
};

/// A drawing whose points are in space.
inline Drawing in_space(std::vector<Shape> shapes, Camera camera = {}) { return {std::move(shapes), {}, camera}; }

/// Where a camera sees a point of space, in a plane picture.
inline Point seen_from(const Camera& camera, const Point& p) {
  const double side = camera.side * std::numbers::pi / 180, above = camera.above * std::numbers::pi / 180;
  return {std::cos(side) * p.x + std::sin(side) * p.y, std::cos(above) * p.z + std::sin(above) * (std::cos(side) * p.y - std::sin(side) * p.x)};
}

/// A drawing with its frames: `frames[i]` are the points at `times[i]`.
struct Animation {
  Drawing drawing{};                         ///< what is drawn
  std::vector<double> times{};               ///< of the frames
  std::vector<std::vector<Point>> frames{};  ///< points at each time
  std::string time_unit = "s";               ///< as the page shows it
};

/// The animation as a plane picture, as its camera sees it; unchanged where it has no camera.
inline Animation as_seen(Animation animation) {
  if (!animation.drawing.camera) return animation;
  const Camera camera = *animation.drawing.camera;
  animation.drawing.camera.reset();
  for (auto* lines : {&animation.frames, &animation.drawing.backdrop})
    for (auto& points : *lines)
      for (Point& p : points) p = seen_from(camera, p);
  return animation;
}

}  // namespace qdot::report
