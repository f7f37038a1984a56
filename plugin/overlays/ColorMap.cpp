#include <osgMidair/ColorMap>

#include <osg/Math>

#include <algorithm>
#include <cmath>

namespace osgMidair
{

namespace
{

float linearFromSrgb(float s)
{
    return s <= 0.04045F ? s / 12.92F : std::pow((s + 0.055F) / 1.055F, 2.4F);
}

float srgbFromLinear(float l)
{
    l = std::clamp(l, 0.0F, 1.0F);
    return l <= 0.0031308F ? 12.92F * l : 1.055F * std::pow(l, 1.0F / 2.4F) - 0.055F;
}

/// Catmull-Rom spline through \a anchors, with the ends extended in a straight line, at \a t in 0
/// .. anchors - 1.
osg::Vec3f spline(const std::vector<osg::Vec3f>& anchors, float t)
{
    const int last = static_cast<int>(anchors.size()) - 1;
    const int i = std::clamp(static_cast<int>(t), 0, last - 1);
    const float f = t - static_cast<float>(i);
    const osg::Vec3f p1 = anchors[i];
    const osg::Vec3f p2 = anchors[i + 1];
    const osg::Vec3f p0 = i > 0 ? anchors[i - 1] : p1 * 2.0F - p2;
    const osg::Vec3f p3 = i + 2 <= last ? anchors[i + 2] : p2 * 2.0F - p1;
    return (p1 * 2.0F + (p2 - p0) * f + (p0 * 2.0F - p1 * 5.0F + p2 * 4.0F - p3) * (f * f) +
            (p1 * 3.0F - p0 - p2 * 3.0F + p3) * (f * f * f)) *
           0.5F;
}

/// Returns \a count points on the spline through \a anchors (Oklab), equally far apart along the
/// curve.
std::vector<osg::Vec3f> evenlySpaced(const std::vector<osg::Vec3f>& anchors, int count)
{
    constexpr int kFine = 4096;
    std::vector<osg::Vec3f> fine(kFine + 1);
    std::vector<float> length(kFine + 1, 0.0F);
    for (int i = 0; i <= kFine; ++i)
    {
        fine[i] =
            spline(anchors, static_cast<float>(i) / kFine * static_cast<float>(anchors.size() - 1));
        if (i > 0) length[i] = length[i - 1] + (fine[i] - fine[i - 1]).length();
    }
    std::vector<osg::Vec3f> even(count);
    for (int k = 0; k < count; ++k)
    {
        const float wanted = length.back() * static_cast<float>(k) / static_cast<float>(count - 1);
        const auto at = std::lower_bound(length.begin(), length.end(), wanted) - length.begin();
        even[k] = fine[std::min<std::ptrdiff_t>(at, kFine)];
    }
    return even;
}

osg::Vec3f lch(float lightness, float chroma, float hueDegrees)
{
    const float hue = osg::DegreesToRadians(hueDegrees);
    return {lightness, chroma * std::cos(hue), chroma * std::sin(hue)};
}

osg::Vec3f rgb8(int red, int green, int blue)
{
    return osg::Vec3f(
               static_cast<float>(red), static_cast<float>(green), static_cast<float>(blue)) /
           255.0F;
}

template<typename LabAt>
std::array<osg::Vec3f, ColorMap::kSize> fill(LabAt labAt)
{
    std::array<osg::Vec3f, ColorMap::kSize> colors;
    for (int i = 0; i < ColorMap::kSize; ++i)
        colors[i] = srgbFromOklab(labAt(i));
    return colors;
}

} // namespace

osg::Vec3f oklabFromSrgb(const osg::Vec3f& srgb)
{
    const float r = linearFromSrgb(srgb.x());
    const float g = linearFromSrgb(srgb.y());
    const float b = linearFromSrgb(srgb.z());
    const float l = std::cbrt(0.4122214708F * r + 0.5363325363F * g + 0.0514459929F * b);
    const float m = std::cbrt(0.2119034982F * r + 0.6806995451F * g + 0.1073969566F * b);
    const float s = std::cbrt(0.0883024619F * r + 0.2817188376F * g + 0.6299787005F * b);
    return {0.2104542553F * l + 0.7936177850F * m - 0.0040720468F * s,
            1.9779984951F * l - 2.4285922050F * m + 0.4505937099F * s,
            0.0259040371F * l + 0.7827717662F * m - 0.8086757660F * s};
}

osg::Vec3f srgbFromOklab(const osg::Vec3f& lab)
{
    const float l = lab.x() + 0.3963377774F * lab.y() + 0.2158037573F * lab.z();
    const float m = lab.x() - 0.1055613458F * lab.y() - 0.0638541728F * lab.z();
    const float s = lab.x() - 0.0894841775F * lab.y() - 1.2914855480F * lab.z();
    const float l3 = l * l * l;
    const float m3 = m * m * m;
    const float s3 = s * s * s;
    return {srgbFromLinear(4.0767416621F * l3 - 3.3077115913F * m3 + 0.2309699292F * s3),
            srgbFromLinear(-1.2684380046F * l3 + 2.6097574011F * m3 - 0.3413193965F * s3),
            srgbFromLinear(-0.0041960863F * l3 - 0.7034186147F * m3 + 1.7076147010F * s3)};
}

const ColorMap& ColorMap::pressure()
{
    static const ColorMap map = through({rgb8(68, 1, 84),
                                         rgb8(59, 82, 139),
                                         rgb8(33, 145, 140),
                                         rgb8(94, 201, 98),
                                         rgb8(253, 231, 37)});
    return map;
}

const ColorMap& ColorMap::radiation()
{
    static const ColorMap map = through({rgb8(72, 18, 88),
                                         rgb8(150, 38, 92),
                                         rgb8(218, 76, 58),
                                         rgb8(248, 146, 36),
                                         rgb8(252, 240, 150)});
    return map;
}

ColorMap ColorMap::through(const std::vector<osg::Vec3f>& colors)
{
    std::vector<osg::Vec3f> anchors;
    anchors.reserve(colors.size());
    for (const osg::Vec3f& color : colors)
        anchors.push_back(oklabFromSrgb(color));
    const std::vector<osg::Vec3f> even = evenlySpaced(anchors, kSize);
    ColorMap made;
    made._colors = fill([&](int i) { return even[i]; });
    return made;
}

const ColorMap& ColorMap::diverging()
{
    // Straight lines in Oklab from the middle: both arms lose the same lightness and gain the same
    // chroma. Blue and orange differ in hue or lightness for red-green and for blue-yellow
    // blindness.
    static const ColorMap map = []
    {
        const osg::Vec3f low = lch(0.50F, 0.15F, 255.0F);
        const osg::Vec3f middle = lch(0.95F, 0.0F, 0.0F);
        const osg::Vec3f high = lch(0.50F, 0.15F, 40.0F);
        ColorMap made;
        made._colors = fill(
            [&](int i)
            {
                const float t = 2.0F * static_cast<float>(i) / (kSize - 1) - 1.0F;
                return t < 0.0F ? middle + (low - middle) * -t : middle + (high - middle) * t;
            });
        return made;
    }();
    return map;
}

const ColorMap& ColorMap::phase()
{
    static const ColorMap map = []
    {
        ColorMap made;
        // At this lightness a chroma of 0.12 lies inside sRGB for every hue.
        made._colors = fill(
            [](int i)
            { return lch(0.73F, 0.12F, 30.0F + 360.0F * static_cast<float>(i) / (kSize - 1)); });
        return made;
    }();
    return map;
}

osg::Vec3f ColorMap::color(float value) const
{
    if (!(value > 0.0F)) return _colors.front();
    if (value >= 1.0F) return _colors.back();
    const float position = value * (kSize - 1);
    const int i = std::min(static_cast<int>(position), kSize - 2);
    const float f = position - static_cast<float>(i);
    return _colors[i] * (1.0F - f) + _colors[i + 1] * f;
}

osg::ref_ptr<osg::Image> ColorMap::createImage() const
{
    osg::ref_ptr<osg::Image> image = new osg::Image;
    image->allocateImage(kSize, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE);
    for (int i = 0; i < kSize; ++i)
        image->setColor(osg::Vec4(_colors[i], 1.0F), i, 0);
    return image;
}

float ColorMap::ratioPosition(float achieved, float wanted)
{
    if (!(wanted > 0.0F) || !(achieved > 0.0F)) return 0.0F;
    return std::clamp(0.5F + 0.5F * std::log2(achieved / wanted), 0.0F, 1.0F);
}

} // namespace osgMidair
