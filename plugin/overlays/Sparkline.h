#pragma once

#include "plugin/overlays/Flat.h"

#include <deque>
#include <string>

namespace osgMidair::flat
{

/// The last values of a figure as a small curve from 0 to their maximum, with its name, the last value and the maximum.
class Sparkline : public osg::Group
{
public:
    /// \a unit follows every number.
    Sparkline(const std::string& name,
              const std::string& unit,
              const osg::Vec2& lowerLeft,
              const osg::Vec2& size);

    void add(double value);
    /// Brings the drawing up to date.
    void redraw();

private:
    static constexpr std::size_t kValues = 120;

    std::string _unit;
    osg::Vec2 _lowerLeft;
    osg::Vec2 _size;
    std::deque<double> _values;
    osg::ref_ptr<osg::Geometry> _curve;
    osg::ref_ptr<osgText::Text> _last;
    osg::ref_ptr<osgText::Text> _most;
};

} // namespace osgMidair::flat
