#include "polyarm/shapes/render.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace polyarm::shapes {

namespace {

constexpr double kEyeDistance = 4.2;  // in radii of the scene
constexpr int kShadow = 96;           // cells of the floor's shadow map in each direction
constexpr double kMargin = 1.04;

struct Eye {
  Vec3 at, right, up, ahead;
  double scale = 1, x = 0, y = 0;  // pixels per unit of the image plane, and its centre in pixels
  /// Projects a point: pixel x, pixel y, and depth.
  Vec3 see(const Vec3& p) const {
    const Vec3 to = p - at;
    const double depth = dot(to, ahead);
    return {x + scale * dot(to, right) / depth, y - scale * dot(to, up) / depth, depth};
  }
};

Vec3 vec(const std::array<float, 3>& p) {
  return {p[0], p[1], p[2]};
}

double linear(double c) {
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}
double encoded(double c) {
  c = std::clamp(c, 0.0, 1.0);
  return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
}

/// The lighting model: sky, floor and three lamps.
class Light {
 public:
  explicit Light(const Eye& eye)
      : key_(normalized(0.55 * eye.right + 0.9 * eye.up - 0.75 * eye.ahead)),
        fill_(normalized(-0.9 * eye.right + 0.25 * eye.up - 0.5 * eye.ahead)),
        rim_(normalized(-0.2 * eye.right + 0.7 * eye.up + 0.8 * eye.ahead)) {}

  Vec3 shade(const Vec3& normal, const Vec3& to_eye, const meshes::MeshPart& part) const {
    const double sky = 0.5 + 0.5 * normal.z;
    double diffuse = 0.26 + 0.34 * sky;
    double gloss = 0;
    const double power = 2 / std::pow(std::max(0.15, static_cast<double>(part.roughness)), 4.0);
    for (const auto& [lamp, strength] :
         {std::pair{key_, 0.62}, std::pair{fill_, 0.16}, std::pair{rim_, 0.2}}) {
      diffuse += strength * std::max(0.0, dot(normal, lamp));
      const Vec3 half = normalized(lamp + to_eye);
      gloss += strength * 0.07 * (power + 2) / 8 * std::pow(std::max(0.0, dot(normal, half)), power);
    }
    const double metal = part.metallic;
    const double edge = std::pow(1 - std::max(0.0, dot(normal, to_eye)), 4.0);
    // The reflection on a smooth surface: a bright sky above a grey floor.
    const Vec3 mirror = 2 * dot(normal, to_eye) * normal - to_eye;
    const double around = 0.30 + 0.55 * std::clamp(0.5 + 1.2 * mirror.z, 0.0, 1.0);
    Vec3 out;
    double* const to[] = {&out.x, &out.y, &out.z};
    for (std::size_t k = 0; k < 3; ++k) {
      const double color = linear(part.color[k]);
      const double spec = metal * color + (1 - metal) * 0.04;
      *to[k] = color * diffuse * (1 - 0.75 * metal) + around * spec * (0.9 + 0.3 * (1 - part.roughness)) +
               (gloss + 0.06 * edge) * (metal > 0.3 ? 0.5 + color : 1.0);
    }
    return out;
  }

 private:
  Vec3 key_, fill_, rim_;
};

class Canvas {
 public:
  Canvas(int width, int height)
      : width_(width),
        height_(height),
        color_(static_cast<std::size_t>(width * height)),
        alpha_(color_.size(), 0.f),
        depth_(color_.size(), std::numeric_limits<float>::max()) {}

  struct Corner {
    Vec3 pixel, normal, to_eye;
  };

  void triangle(const std::array<Corner, 3>& c, const meshes::MeshPart& part, const Light& light) {
    const auto span = [&](auto get, int most) {
      const auto [low, high] = std::minmax({get(c[0]), get(c[1]), get(c[2])});
      return std::pair{std::clamp(static_cast<int>(std::floor(low)), 0, most - 1),
                       std::clamp(static_cast<int>(std::ceil(high)), 0, most - 1)};
    };
    const Vec3 a = c[0].pixel, b = c[1].pixel - a, d = c[2].pixel - a;
    const double area = b.x * d.y - b.y * d.x;
    if (std::abs(area) < 1e-12) return;
    const auto [x0, x1] = span([](const Corner& k) { return k.pixel.x; }, width_);
    const auto [y0, y1] = span([](const Corner& k) { return k.pixel.y; }, height_);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const double px = x + 0.5 - a.x, py = y + 0.5 - a.y;
        const double u = (px * d.y - py * d.x) / area, v = (b.x * py - b.y * px) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        const auto at = static_cast<std::size_t>(y * width_ + x);
        const auto depth = static_cast<float>(a.z + u * b.z + v * d.z);
        if (depth >= depth_[at]) continue;
        depth_[at] = depth;
        const Vec3 to_eye = normalized((1 - u - v) * c[0].to_eye + u * c[1].to_eye + v * c[2].to_eye);
        Vec3 normal = normalized((1 - u - v) * c[0].normal + u * c[1].normal + v * c[2].normal);
        if (dot(normal, to_eye) < 0) normal = -normal;
        color_[at] = light.shade(normal, to_eye, part);
        alpha_[at] = 1;
      }
  }

  /// Puts black with this opacity on a pixel that is still empty.
  void shade(int x, int y, double opacity) {
    const auto at = static_cast<std::size_t>(y * width_ + x);
    if (alpha_[at] == 0) alpha_[at] = static_cast<float>(opacity);
  }
  bool empty(int x, int y) const { return alpha_[static_cast<std::size_t>(y * width_ + x)] == 0; }
  int width() const { return width_; }
  int height() const { return height_; }

  /// Averages blocks of `samples`² pixels.
  Picture picture(int samples) const {
    Picture out{width_ / samples, height_ / samples, {}};
    out.rgba.resize(static_cast<std::size_t>(4 * out.width * out.height));
    for (int y = 0; y < out.height; ++y)
      for (int x = 0; x < out.width; ++x) {
        Vec3 sum;
        double alpha = 0;
        for (int k = 0; k < samples * samples; ++k) {
          const auto at =
              static_cast<std::size_t>((y * samples + k / samples) * width_ + x * samples + k % samples);
          alpha += alpha_[at];
          sum = sum + static_cast<double>(alpha_[at]) * color_[at];
        }
        std::uint8_t* const to = &out.rgba[static_cast<std::size_t>(4 * (y * out.width + x))];
        const double one = alpha > 0 ? 1 / alpha : 0;
        to[0] = static_cast<std::uint8_t>(std::lround(255 * encoded(one * sum.x)));
        to[1] = static_cast<std::uint8_t>(std::lround(255 * encoded(one * sum.y)));
        to[2] = static_cast<std::uint8_t>(std::lround(255 * encoded(one * sum.z)));
        to[3] = static_cast<std::uint8_t>(std::lround(255 * alpha / (samples * samples)));
      }
    return out;
  }

 private:
  int width_, height_;
  std::vector<Vec3> color_;
  std::vector<float> alpha_, depth_;
};

struct Box {
  Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  void add(const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
};

template <typename Use>
void each_position(std::span<const Placed> things, Use use) {
  for (const Placed& thing : things)
    for (const meshes::MeshPart& part : *thing.mesh)
      for (const auto& p : part.positions) use(thing.pose * vec(p));
}

/// The shadow on the floor: objects near the floor darken the cell below them and its neighbours.
class Shadow {
 public:
  Shadow(std::span<const Placed> things, double floor, const Box& box) : floor_(floor) {
    const double wide = 0.12 * norm(box.high - box.low);
    low_ = {box.low.x - wide, box.low.y - wide, 0};
    size_ = {box.high.x - box.low.x + 2 * wide, box.high.y - box.low.y + 2 * wide, 0};
    cells_.assign(kShadow * kShadow, 0);
    const double fade = 0.35 * (box.high.z - box.low.z) + 0.02;
    each_position(things, [&](const Vec3& p) {
      const double dark = std::exp(-std::max(0.0, p.z - floor) / fade);
      double& cell = cells_[static_cast<std::size_t>(index(p))];
      cell = std::max(cell, dark);
    });
    for (int pass = 0; pass < 3; ++pass) blur();
  }
  double at(const Vec3& p) const {
    const double x = (p.x - low_.x) / size_.x * kShadow - 0.5, y = (p.y - low_.y) / size_.y * kShadow - 0.5;
    if (x < 0 || y < 0 || x >= kShadow - 1 || y >= kShadow - 1) return 0;
    const auto i = static_cast<std::size_t>(x), j = static_cast<std::size_t>(y);
    const double u = x - static_cast<double>(i), v = y - static_cast<double>(j);
    const auto cell = [&](std::size_t a, std::size_t b) { return cells_[b * kShadow + a]; };
    return (1 - v) * ((1 - u) * cell(i, j) + u * cell(i + 1, j)) +
           v * ((1 - u) * cell(i, j + 1) + u * cell(i + 1, j + 1));
  }
  double floor() const { return floor_; }

 private:
  int index(const Vec3& p) const {
    const int x = std::clamp(static_cast<int>((p.x - low_.x) / size_.x * kShadow), 0, kShadow - 1);
    const int y = std::clamp(static_cast<int>((p.y - low_.y) / size_.y * kShadow), 0, kShadow - 1);
    return y * kShadow + x;
  }
  void blur() {
    constexpr int kRadius = 4;
    for (const bool rows : {true, false}) {
      std::vector<double> out(cells_.size(), 0);
      for (int a = 0; a < kShadow; ++a)
        for (int b = 0; b < kShadow; ++b)
          for (int d = -kRadius; d <= kRadius; ++d) {
            const int k = std::clamp(b + d, 0, kShadow - 1);
            out[static_cast<std::size_t>(rows ? a * kShadow + b : b * kShadow + a)] +=
                cells_[static_cast<std::size_t>(rows ? a * kShadow + k : k * kShadow + a)] /
                (2 * kRadius + 1);
          }
      cells_ = std::move(out);
    }
  }
  double floor_;
  Vec3 low_, size_;
  std::vector<double> cells_;
};

Eye eye_for(const Box& box, const View& view) {
  Eye out;
  const Vec3 to_eye{std::cos(view.elevation) * std::cos(view.azimuth),
                    std::cos(view.elevation) * std::sin(view.azimuth), std::sin(view.elevation)};
  out.ahead = -to_eye;
  out.right = {-std::sin(view.azimuth), std::cos(view.azimuth), 0};
  out.up = cross(to_eye, out.right);
  const double radius = std::max(0.5 * norm(box.high - box.low), 1e-3);
  out.at = 0.5 * (box.low + box.high) + kEyeDistance * radius * to_eye;
  return out;
}

/// Sizes the picture to the visible extent of the objects.
std::pair<int, int> frame(Eye& eye, std::span<const Placed> things, int size) {
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  each_position(things, [&](const Vec3& p) {
    const Vec3 seen = eye.see(p);
    left = std::min(left, seen.x), right = std::max(right, seen.x);
    top = std::min(top, seen.y), bottom = std::max(bottom, seen.y);
  });
  const double wide = kMargin * (right - left) + 0.02 * (bottom - top),
               tall = kMargin * (bottom - top) + 0.06 * (right - left);
  eye.scale = size / std::max(wide, tall);
  const int width = std::max(8, static_cast<int>(std::lround(eye.scale * wide)));
  const int height = std::max(8, static_cast<int>(std::lround(eye.scale * tall)));
  eye.x = width / 2.0 - eye.scale * (left + right) / 2;
  eye.y = height / 2.0 - eye.scale * (top + bottom) / 2 - 0.02 * height;
  return {width, height};
}

void draw_floor(Canvas& canvas, const Eye& eye, const Shadow& shadow) {
  for (int y = 0; y < canvas.height(); ++y)
    for (int x = 0; x < canvas.width(); ++x) {
      if (!canvas.empty(x, y)) continue;
      const Vec3 ray =
          eye.ahead + ((x + 0.5 - eye.x) / eye.scale) * eye.right - ((y + 0.5 - eye.y) / eye.scale) * eye.up;
      if (ray.z >= -1e-6) continue;
      const double t = (shadow.floor() - eye.at.z) / ray.z;
      canvas.shade(x, y, 0.55 * shadow.at(eye.at + t * ray));
    }
}

}  // namespace

Picture draw(std::span<const Placed> things, const View& view) {
  Box box;
  each_position(things, [&](const Vec3& p) { box.add(p); });
  if (box.low.x > box.high.x) return {};
  Eye eye = eye_for(box, view);
  const auto [wide, tall] = frame(eye, things, view.size);
  eye.scale *= view.samples, eye.x *= view.samples, eye.y *= view.samples;
  Canvas canvas(wide * view.samples, tall * view.samples);
  const Light light(eye);
  for (const Placed& thing : things)
    for (const meshes::MeshPart& part : *thing.mesh) {
      std::vector<Canvas::Corner> corners(part.positions.size());
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3 p = thing.pose * vec(part.positions[i]);
        corners[i] = {eye.see(p), thing.pose.rotation * vec(part.normals[i]), normalized(eye.at - p)};
      }
      for (std::size_t t = 0; t + 2 < part.triangles.size(); t += 3)
        canvas.triangle(
            {corners[part.triangles[t]], corners[part.triangles[t + 1]], corners[part.triangles[t + 2]]},
            part, light);
    }
  draw_floor(canvas, eye, Shadow(things, view.floor, box));
  return canvas.picture(view.samples);
}

}  // namespace polyarm::shapes
