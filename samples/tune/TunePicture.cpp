#include "samples/tune/TunePicture.h"

#include "haptics/base/Units.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <vector>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using haptics::TransducerState;

// Pixels.
constexpr double kWidth = 1200.0;
constexpr double kMargin = 40.0;
constexpr double kTop = 90.0;
constexpr double kGap = 26.0;
constexpr double kHistogram = 230.0;
constexpr double kMostScale = 5500.0; // pixels a metre
constexpr int kAcross = 4;            // sides beside each other

constexpr double kFullColor_deg = 45.0;

// Blue to white to orange, told apart by people who see red and green alike, too.
std::string colorOf(double phase_deg)
{
    const std::array<double, 3> low = {20, 90, 170}, high = {200, 95, 10}, none = {247, 247, 247};
    const double t = std::clamp(phase_deg / kFullColor_deg, -1.0, 1.0);
    std::array<int, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c)
        rgb[c] = static_cast<int>(none[c] + std::abs(t) * ((t < 0 ? low[c] : high[c]) - none[c]));
    return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

std::string escaped(const std::string& text)
{
    std::string safe;
    for (const char c : text)
        if (c == '<')
            safe += "&lt;";
        else if (c == '&')
            safe += "&amp;";
        else if (static_cast<unsigned char>(c) >= ' ')
            safe += c;
    return safe;
}

/// Transducers that look the same way, in the plane of their side: x to the right and y up, seen
/// from where they emit to.
struct Side
{
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    std::vector<int> which = {};
    Eigen::Matrix2Xd at = {};
    Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = Eigen::Vector2d::Zero();
};

std::vector<Side> sidesOf(const haptics::TransducerArray& array)
{
    std::vector<Side> sides;
    for (int i = 0; i < array.size(); ++i)
    {
        const Eigen::Vector3d n = array.normals.col(i);
        auto side = std::find_if(sides.begin(),
                                 sides.end(),
                                 [&](const Side& known) { return known.normal.dot(n) > 0.999; });
        if (side == sides.end()) side = sides.insert(side, Side{n});
        side->which.push_back(i);
    }
    for (Side& side : sides)
    {
        const Eigen::Vector3d n = side.normal;
        const bool isLevel = std::abs(n.y()) > 0.9; // then x is to the right
        const Eigen::Vector3d right = isLevel ? (Eigen::Vector3d::UnitX() - n.x() * n).normalized()
                                              : Eigen::Vector3d::UnitY().cross(n).normalized();
        const Eigen::Vector3d up = n.cross(right);
        side.at.resize(2, static_cast<Eigen::Index>(side.which.size()));
        for (std::size_t k = 0; k < side.which.size(); ++k)
        {
            const Eigen::Vector3d r = array.positions.col(side.which[k]);
            side.at.col(static_cast<Eigen::Index>(k)) << right.dot(r), up.dot(r);
        }
        side.low = side.at.rowwise().minCoeff();
        side.high = side.at.rowwise().maxCoeff();
    }
    return sides;
}

// The distance of nearest neighbours, of some of them.
double pitchOf(const std::vector<Side>& sides)
{
    double pitch = 1e9;
    for (const Side& side : sides)
        for (Eigen::Index a = 0; a < side.at.cols();
             a += std::max<Eigen::Index>(1, side.at.cols() / 8))
            for (Eigen::Index b = 0; b < side.at.cols(); ++b)
                if (const double d = (side.at.col(a) - side.at.col(b)).norm(); d > 1e-6)
                    pitch = std::min(pitch, d);
    return pitch < 1e9 ? pitch : 10e-3;
}

/// The sheet, drawn from the top.
class Sheet
{
public:
    explicit Sheet(const haptics::TuningFit& fit) : _fit(fit) {}

    std::string draw()
    {
        drawTitle();
        drawMaps();
        drawKey();
        drawPhases();
        drawGains();
        const double height = _y + kHistogram + 60.0;
        return fmt::format(
                   "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
                   "font-family=\"DejaVu Sans, sans-serif\" font-size=\"16\" fill=\"#1a1a1e\">\n"
                   "<rect width=\"{0:.0f}\" height=\"{1:.0f}\" fill=\"#ffffff\"/>\n",
                   kWidth,
                   height) +
               _text + "</svg>\n";
    }

private:
    template<typename... Values>
    void add(const char* format, const Values&... values)
    {
        _text += fmt::format(fmt::runtime(format), values...);
    }

    void
    text(double x, double y, const std::string& what, const char* anchor = "start", int size = 16)
    {
        add("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" font-size=\"{}\">{}</text>\n",
            x,
            y,
            anchor,
            size,
            escaped(what));
    }

    std::size_t count(TransducerState state) const { return _fit.of(state).size(); }

    void drawTitle()
    {
        const std::size_t fine = count(TransducerState::FINE),
                          reversed = count(TransducerState::REVERSED);
        text(kMargin,
             40,
             fmt::format("{}: {} of {} transducers play, {} of them reversed; {} dead",
                         _fit.array.name,
                         fine + reversed,
                         _fit.array.size(),
                         reversed,
                         count(TransducerState::DEAD)),
             "start",
             22);
        text(kMargin,
             66,
             fmt::format(
                 "phases spread {:.1f} degrees (polarity aside), gains {:.1f} %; sides are seen "
                 "from where they emit to",
                 base::toDegrees(_fit.phaseSpread_rad),
                 100.0 * _fit.gainSpread));
        _y = kTop;
    }

    double phase_deg(int i) const
    {
        const double phase = base::toDegrees(_fit.array.phaseOffset_rad[i]);
        return phase - 180.0 * std::round(phase / 180.0);
    }

    void drawTransducer(double x, double y, double r, TransducerState state, double phase_deg)
    {
        switch (state)
        {
        case TransducerState::FINE:
        case TransducerState::REVERSED:
            add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"{}\" stroke=\"#b8bbc0\" "
                "stroke-width=\"0.6\"/>\n",
                x,
                y,
                r,
                colorOf(phase_deg));
            if (state == TransducerState::REVERSED)
                add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>\n", x, y, 0.3 * r);
            break;
        case TransducerState::DEAD:
            add("<path d=\"M{:.1f} {:.1f}l{:.1f} {:.1f}m0 {:.1f}l{:.1f} {:.1f}\" "
                "stroke=\"#c00020\" "
                "stroke-width=\"{:.1f}\" fill=\"none\"/>\n",
                x - r,
                y - r,
                2 * r,
                2 * r,
                -2 * r,
                -2 * r,
                2 * r,
                std::max(1.2, 0.35 * r));
            break;
        case TransducerState::UNSURE:
        case TransducerState::NOT_MEASURED:
            add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"none\" stroke=\"#606468\" "
                "stroke-dasharray=\"2 2\"/>\n",
                x,
                y,
                r);
            break;
        }
    }

    void drawMaps()
    {
        const std::vector<Side> sides = sidesOf(_fit.array);
        const double pitch = pitchOf(sides);
        const int across = std::min<int>(kAcross, static_cast<int>(sides.size()));
        Eigen::Vector2d largest(0, 0);
        for (const Side& side : sides)
            largest = largest.cwiseMax(side.high - side.low);
        largest.array() += pitch;
        const double room = (kWidth - 2 * kMargin - (across - 1) * kGap) / across;
        const double scale = std::min(kMostScale, room / largest.x());
        const double r = 0.42 * pitch * scale;
        for (std::size_t s = 0; s < sides.size(); ++s)
        {
            const Side& side = sides[s];
            const int column = static_cast<int>(s) % across, row = static_cast<int>(s) / across;
            const double left = kMargin + column * (room + kGap);
            const double top = _y + row * (largest.y() * scale + kGap + 22.0) + 22.0;
            text(left,
                 top - 6.0,
                 fmt::format("facing ({:.2g}, {:.2g}, {:.2g})",
                             rounded(side.normal.x()),
                             rounded(side.normal.y()),
                             rounded(side.normal.z())),
                 "start",
                 13);
            for (std::size_t k = 0; k < side.which.size(); ++k)
            {
                const auto at = side.at.col(static_cast<Eigen::Index>(k));
                const int i = side.which[k];
                drawTransducer(left + (at.x() - side.low.x() + 0.5 * pitch) * scale,
                               top + (side.high.y() - at.y() + 0.5 * pitch) * scale,
                               r,
                               _fit.states[static_cast<std::size_t>(i)],
                               phase_deg(i));
            }
        }
        const int rows = (static_cast<int>(sides.size()) + across - 1) / across;
        _y += rows * (largest.y() * scale + kGap + 22.0) + 10.0;
    }

    static double rounded(double value) { return std::round(100.0 * value) / 100.0 + 0.0; }

    void drawKey()
    {
        double x = kMargin;
        for (const double phase : {-45.0, -30.0, -15.0, 0.0, 15.0, 30.0, 45.0})
        {
            add("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"44\" height=\"16\" fill=\"{}\" "
                "stroke=\"#b8bbc0\"/>\n",
                x,
                _y,
                colorOf(phase));
            text(x + 22, _y + 32, fmt::format("{:g}", phase), "middle", 13);
            x += 44;
        }
        text(x + 8, _y + 14, "degrees", "start", 13);
        x += 80;
        const std::array<std::pair<TransducerState, const char*>, 4> marks = {
            {{TransducerState::FINE, "as most"},
             {TransducerState::REVERSED, "reversed"},
             {TransducerState::DEAD, "dead"},
             {TransducerState::NOT_MEASURED, "not measured, or in noise"}}};
        for (const auto& [state, name] : marks)
        {
            drawTransducer(x, _y + 8, 8, state, 0.0);
            text(x + 16, _y + 13, name, "start", 13);
            x += 105;
        }
        for (const auto& [color, name] :
             {std::pair("#4a90c2", "bars: as most"), std::pair("#e0a040", "reversed")})
        {
            add("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"16\" height=\"16\" fill=\"{}\"/>\n",
                x + 95.0,
                _y,
                color);
            text(x + 117.0, _y + 13, name, "start", 13);
            x += 130.0;
        }
        _y += 72.0;
    }

    /// Bars from \a low to \a high, of those fine and those reversed upon them.
    void drawHistogram(double left,
                       double low,
                       double high,
                       int bins,
                       const std::string& name,
                       double tick,
                       const std::function<double(int)>& valueOf)
    {
        const double width = 0.5 * (kWidth - 2 * kMargin - 80.0);
        std::vector<std::array<int, 2>> counts(static_cast<std::size_t>(bins), {0, 0});
        int most = 1;
        for (int i = 0; i < _fit.array.size(); ++i)
        {
            const TransducerState state = _fit.states[static_cast<std::size_t>(i)];
            if (state != TransducerState::FINE && state != TransducerState::REVERSED) continue;
            const double share = (valueOf(i) - low) / (high - low);
            auto& bin = counts[static_cast<std::size_t>(
                std::clamp(static_cast<int>(share * bins), 0, bins - 1))];
            ++bin[state == TransducerState::REVERSED ? 1 : 0];
            most = std::max(most, bin[0] + bin[1]);
        }
        const double step = width / bins, base = _y + kHistogram;
        for (int b = 0; b < bins; ++b)
        {
            double top = base;
            for (const std::size_t part : {0U, 1U})
            {
                const double h =
                    kHistogram * counts[static_cast<std::size_t>(b)][part] / (1.05 * most);
                top -= h;
                add("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" "
                    "fill=\"{}\"/>\n",
                    left + b * step + 0.5,
                    top,
                    step - 1.0,
                    h,
                    part == 0 ? "#4a90c2" : "#e0a040");
            }
        }
        add("<path d=\"M{:.1f} {:.1f}h{:.1f}\" stroke=\"#1a1a1e\"/>\n", left, base, width);
        for (double at = std::ceil(low / tick) * tick; at <= high + 1e-9; at += tick)
            text(left + width * (at - low) / (high - low),
                 base + 18,
                 fmt::format("{:.3g}", at),
                 "middle",
                 13);
        text(left,
             base - kHistogram - 8,
             fmt::format("{} (highest bar: {})", name, most),
             "start",
             14);
    }

    void drawPhases()
    {
        drawHistogram(kMargin,
                      -90,
                      90,
                      60,
                      "transducers by phase in degrees, polarity aside",
                      30,
                      [this](int i) { return phase_deg(i); });
    }

    void drawGains()
    {
        drawHistogram(kMargin + 0.5 * (kWidth - 2 * kMargin - 80.0) + 80.0,
                      0.0,
                      1.5,
                      60,
                      "by gain; the median is 1",
                      0.25,
                      [this](int i) { return _fit.array.gain[i]; });
    }

    const haptics::TuningFit& _fit;
    std::string _text;
    double _y = 0.0;
};

} // namespace

std::string pictureOf(const haptics::TuningFit& fit)
{
    return Sheet(fit).draw();
}

} // namespace midair::samples
