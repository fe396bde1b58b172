#include "report/colour_scale.h"

#include <patchwright/base/error.h>
#include <patchwright/report/picture.h>

#include <zlib.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace patchwright::report {

namespace {

using geom::Vec3;

/// Each pixel is the mean of so many in a square.
constexpr int finer = 2;
constexpr double margin = 0.03;  ///< of the width and height
/// Lines are drawn this far before the surface that they lie on, fraction of the picture's extent.
constexpr double line_lift = 4e-3;
constexpr base::Colour grey{0.72, 0.74, 0.77};

struct LineStyle {
    std::array<float, 3> colour;
    int width;  ///< fine pixels
};
constexpr LineStyle curve_style{{0.08F, 0.08F, 0.1F}, 2};

LineStyle style_of(PictureLine::Kind kind) {
    switch (kind) {
        case PictureLine::Kind::Plain: break;
        case PictureLine::Kind::SemiSharp: return {{0.35F, 0.78F, 0.24F}, 4};
        case PictureLine::Kind::Crease: return {{0.0F, 0.47F, 0.16F}, 4};
        case PictureLine::Kind::Border: return {{0.86F, 0.0F, 0.0F}, 3};
    }
    return {{0.08F, 0.08F, 0.16F}, 1};
}

struct Pixel {
    float depth = std::numeric_limits<float>::lowest();  ///< larger is nearer
    std::array<float, 3> colour{};
    int face = -1;  ///< -2: a line
};

/// Orthographic: x right, y down, z towards the eye; in fine pixels.
class Projection {
  public:
    Projection(const measure::Field& field, const PictureOptions& options)
        : width(finer * options.width), height(finer * options.height) {
        eye_ = options.towards_eye.normalized();
        const Vec3 up = std::abs(eye_.z()) > 0.999 ? Vec3::UnitY() : Vec3::UnitZ();
        right_ = up.cross(eye_).normalized();
        up_ = eye_.cross(right_);
        if (options.frame) {
            scale_ = width / options.frame->width;
            middle_ = turned(options.frame->centre);
            return;
        }
        geom::Box3 box;
        for (Eigen::Index i = 0; i < field.points.rows(); ++i)
            box.add(turned(field.points.row(i).transpose()));
        const Vec3 size = (box.max - box.min).cwiseMax(1e-12);
        scale_ = (1.0 - 2.0 * margin) * std::min(width / size.x(), height / size.y());
        middle_ = box.centre();
    }

    [[nodiscard]] Vec3 operator()(const Vec3& p) const {
        const Vec3 q = scale_ * (turned(p) - middle_);
        return {0.5 * width + q.x(), 0.5 * height - q.y(), q.z()};
    }
    [[nodiscard]] const Vec3& eye() const { return eye_; }
    [[nodiscard]] const Vec3& up() const { return up_; }
    /// From above the left shoulder.
    [[nodiscard]] Vec3 light() const { return (eye_ + 0.4 * up_ - 0.3 * right_).normalized(); }

    int width, height;

  private:
    [[nodiscard]] Vec3 turned(const Vec3& p) const {
        return {right_.dot(p), up_.dot(p), eye_.dot(p)};
    }
    Vec3 eye_, right_, up_, middle_;
    double scale_ = 1.0;
};

class Painter {
  public:
    Painter(const measure::Field& field, const PictureOptions& options,
            const std::vector<PictureLine>& edges)
        : field_(field),
          options_(options),
          edges_(edges),
          project_(field, options),
          pixels_(std::size_t(project_.width) * std::size_t(project_.height)) {}

    std::vector<unsigned char> paint() {
        choose_values();
        for (std::size_t i = 0; i < field_.triangles.size(); ++i) triangle(i);
        for (const geom::Points& line : field_.lines) polyline(line, curve_style);
        // Those that mean more over the others.
        for (const auto kind : {PictureLine::Kind::Plain, PictureLine::Kind::SemiSharp,
                                PictureLine::Kind::Crease, PictureLine::Kind::Border})
            for (const PictureLine& edge : edges_)
                if (edge.kind == kind) polyline(edge.points, style_of(kind));
        return averaged();
    }

  private:
    Pixel& at(int x, int y) {
        return pixels_[std::size_t(y) * std::size_t(project_.width) + std::size_t(x)];
    }

    /// @param weights  of the triangle's corners
    [[nodiscard]] Vec3 colour_at(std::size_t number, const Vec3& weights) const {
        const std::array<int, 3>& t = field_.triangles[number];
        Vec3 normal = Vec3::Zero();
        for (int k = 0; k < 3; ++k)
            normal += weights[k] * field_.normals.row(t[std::size_t(k)]).transpose();
        normal.normalize();
        if (normal.dot(project_.eye()) < 0.0) normal = -normal;
        if (options_.layer == PictureLayer::Zebra) return Vec3::Constant(stripe(normal));
        double share = 0.0;
        if (values_ != nullptr)
            for (int k = 0; k < 3; ++k)
                share += weights[k] * (*values_)[std::size_t(t[std::size_t(k)])] / scale_;
        base::Colour colour = grey;
        if (options_.layer == PictureLayer::Patches)
            colour = face_colour(field_.faces[number]);
        else if (values_ == &field_.curvature)
            colour = diverging_colour(share);
        else if (values_ != nullptr)
            colour = scale_colour(share);
        constexpr double least_light = 0.35;
        const double light = std::max(project_.light().dot(normal), 0.0);
        return (least_light + (1.0 - least_light) * light) *
               Vec3(colour.red, colour.green, colour.blue);
    }

    /// Lamps all around, along the picture's width, as the page's view has them.
    [[nodiscard]] double stripe(const Vec3& normal) const {
        constexpr double stripes = 14.0, dark = 0.06, bright = 0.96;
        const Vec3 mirrored = 2.0 * project_.eye().dot(normal) * normal - project_.eye();
        const double place =
            stripes * std::acos(std::clamp(project_.up().dot(mirrored), -1.0, 1.0)) / M_PI;
        return std::abs(place - std::floor(place) - 0.5) > 0.25 ? bright : dark;
    }

    void choose_values() {
        const auto largest = [](const std::vector<double>& values) {
            const auto at = std::max_element(values.begin(), values.end());
            return at != values.end() && *at > 0.0 ? *at : 1.0;
        };
        if (options_.layer == PictureLayer::Curvature && !field_.curvature.empty()) {
            values_ = &field_.curvature;
            scale_ = usual_curvature({&field_});
        } else if (options_.layer == PictureLayer::Deviation && !field_.distance_mm.empty()) {
            values_ = &field_.distance_mm;
            scale_ = options_.scale_mm;
        } else if (options_.layer == PictureLayer::NormalAngle && !field_.distance_mm.empty()) {
            values_ = &field_.normal_angle_rad;
            scale_ = largest(field_.normal_angle_rad);
        }
    }

    void triangle(std::size_t number) {
        std::array<Vec3, 3> p;
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = project_(field_.points.row(field_.triangles[number][k]).transpose());
        const auto cross = [](const Vec3& a, const Vec3& b, double x, double y) {
            return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
        };
        const double area = cross(p[0], p[1], p[2].x(), p[2].y());
        if (area == 0.0) return;
        const Vec3 low = p[0].cwiseMin(p[1]).cwiseMin(p[2]),
                   high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
        const int x_end = pixel_at(high.x() + 0.5, project_.width);
        const int y_end = pixel_at(high.y() + 0.5, project_.height);
        for (int y = std::max(pixel_at(low.y() - 0.5, project_.height), 0); y <= y_end; ++y) {
            for (int x = std::max(pixel_at(low.x() - 0.5, project_.width), 0); x <= x_end; ++x) {
                const double a = cross(p[1], p[2], x + 0.5, y + 0.5) / area;
                const double b = cross(p[2], p[0], x + 0.5, y + 0.5) / area;
                const double c = 1.0 - a - b;
                if (a < 0.0 || b < 0.0 || c < 0.0) continue;
                const auto depth = float(a * p[0].z() + b * p[1].z() + c * p[2].z());
                Pixel& pixel = at(x, y);
                if (depth <= pixel.depth) continue;
                const Vec3 mixed = colour_at(number, {a, b, c});
                pixel = {depth,
                         {float(mixed.x()), float(mixed.y()), float(mixed.z())},
                         field_.faces[number]};
            }
        }
    }

    /// -1 and the last one for places outside of the picture, so that ranges are empty there.
    static int pixel_at(double place, int count) {
        return int(std::clamp(std::floor(place), -1.0, double(count - 1)));
    }

    void polyline(const geom::Points& line, const LineStyle& style) {
        for (Eigen::Index i = 0; i + 1 < line.rows(); ++i)
            segment(project_(line.row(i).transpose()), project_(line.row(i + 1).transpose()),
                    style);
    }

    /// The part of a line that can be seen, as parameters from 0 to 1.
    /// Source: Liang and Barsky, A new concept and method for line clipping (1984).
    [[nodiscard]] std::pair<double, double> seen_part(const Vec3& a, const Vec3& b,
                                                      int width) const {
        double from = 0.0, to = 1.0;
        for (const auto& [axis, size] : {std::pair(0, project_.width), {1, project_.height}}) {
            const double change = b[axis] - a[axis];
            double low = -width - a[axis], high = size + width - a[axis];
            if (change < 0.0) std::swap(low, high);
            if (change == 0.0) {
                if (low > 0.0 || high < 0.0) return {1.0, 0.0};
                continue;
            }
            from = std::max(from, low / change);
            to = std::min(to, high / change);
        }
        return {from, to};
    }

    void segment(const Vec3& a, const Vec3& b, const LineStyle& style) {
        const auto [from, to] = seen_part(a, b, style.width);
        if (from > to) return;
        const Vec3 begin = a + from * (b - a), change = (to - from) * (b - a);
        const int steps = std::max(1, int(std::ceil(change.head<2>().norm())));
        const double lift = line_lift * std::max(project_.width, project_.height);
        for (int i = 0; i <= steps; ++i) {
            const Vec3 p = begin + change * (double(i) / steps);
            for (int k = 0; k < style.width * style.width; ++k) {
                const int x = int(p.x()) + k % style.width - (style.width - 1) / 2;
                const int y = int(p.y()) + k / style.width - (style.width - 1) / 2;
                if (x < 0 || y < 0 || x >= project_.width || y >= project_.height) continue;
                Pixel& pixel = at(x, y);
                if (p.z() + lift < pixel.depth) continue;
                pixel.colour = style.colour;
                pixel.face = -2;
            }
        }
    }

    /// Beside a pixel of another face.
    bool is_border(int x, int y) {
        const int face = at(x, y).face;
        if (face < 0) return false;
        for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1)}) {
            if (x + dx >= project_.width || y + dy >= project_.height) continue;
            const int other = at(x + dx, y + dy).face;
            if (other >= 0 && other != face) return true;
        }
        return false;
    }

    /// Rows of RGBA.
    std::vector<unsigned char> averaged() {
        std::vector<unsigned char> rows;
        rows.reserve(std::size_t(options_.width) * std::size_t(options_.height) * 4);
        for (int y = 0; y < options_.height; ++y)
            for (int x = 0; x < options_.width; ++x)
                for (const double value : mean(finer * x, finer * y))
                    rows.push_back(static_cast<unsigned char>(
                        std::lround(255.0 * std::clamp(value, 0.0, 1.0))));
        return rows;
    }

    std::array<double, 4> mean(int x0, int y0) {
        constexpr double border_darkness = 0.45;
        std::array<double, 4> sum{};
        for (int y = y0; y < y0 + finer; ++y) {
            for (int x = x0; x < x0 + finer; ++x) {
                const Pixel& pixel = at(x, y);
                if (pixel.face == -1) continue;
                const double factor = is_border(x, y) ? border_darkness : 1.0;
                for (std::size_t k = 0; k < 3; ++k) sum[k] += factor * double(pixel.colour[k]);
                sum[3] += 1.0;
            }
        }
        const double all = double(finer * finer);
        if (!options_.is_transparent) {
            for (std::size_t k = 0; k < 3; ++k) sum[k] = (sum[k] + all - sum[3]) / all;
            sum[3] = 1.0;
            return sum;
        }
        if (sum[3] > 0.0)
            for (std::size_t k = 0; k < 3; ++k) sum[k] /= sum[3];
        sum[3] /= all;
        return sum;
    }

    const measure::Field& field_;
    const PictureOptions& options_;
    const std::vector<PictureLine>& edges_;
    Projection project_;
    std::vector<Pixel> pixels_;
    const std::vector<double>* values_ = nullptr;  ///< of the layer, if it has any
    double scale_ = 1.0;
};

void append_number(std::string& bytes, std::uint32_t value) {
    for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(value >> shift & 0xff);
}

void append_chunk(std::string& png, const std::string& kind, const std::string& data) {
    append_number(png, std::uint32_t(data.size()));
    const std::string checked = kind + data;
    png += checked;
    append_number(png, std::uint32_t(::crc32(0, reinterpret_cast<const Bytef*>(checked.data()),
                                             uInt(checked.size()))));
}

/// Source: Portable Network Graphics, W3C (2003): colour type 6, each row as differences from the
/// one above.
std::string png_of(const std::vector<unsigned char>& rgba, int width, int height) {
    const std::size_t row = std::size_t(width) * 4;
    std::string filtered;
    for (std::size_t y = 0; y < std::size_t(height); ++y) {
        constexpr char up_filter = 2;
        filtered += up_filter;
        for (std::size_t x = 0; x < row; ++x) {
            const int above = y > 0 ? rgba[(y - 1) * row + x] : 0;
            filtered += static_cast<char>(rgba[y * row + x] - above);
        }
    }
    uLongf size = ::compressBound(uLong(filtered.size()));
    std::string packed(size, '\0');
    if (::compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                    reinterpret_cast<const Bytef*>(filtered.data()), uLong(filtered.size()),
                    Z_BEST_COMPRESSION) != Z_OK)
        throw base::OutputError("the picture cannot be compressed");
    packed.resize(size);
    std::string header;
    append_number(header, std::uint32_t(width));
    append_number(header, std::uint32_t(height));
    header += {8, 6, 0, 0, 0};  // bits, colour type, and the only kinds there are
    std::string png = "\x89PNG\r\n\x1a\n";
    append_chunk(png, "IHDR", header);
    append_chunk(png, "IDAT", packed);
    append_chunk(png, "IEND", "");
    return png;
}

}  // namespace

std::string to_png(const measure::Field& field, const PictureOptions& options,
                   const std::vector<PictureLine>& edges) {
    constexpr int most_pixels = 8192;
    if (options.width < 1 || options.height < 1 || options.width > most_pixels ||
        options.height > most_pixels || !(options.scale_mm > 0.0) ||
        !(options.towards_eye.norm() > 0.0) || (options.frame && !(options.frame->width > 0.0)))
        throw base::InvalidArgument("to_png: size, scale or view is out of range");
    return png_of(Painter(field, options, edges).paint(), options.width, options.height);
}

}  // namespace patchwright::report
