#pragma once

#include <osg/Group>
#include <osg/Vec2>
#include <osg/Vec4>
#include <osgText/Text>

#include <string>
#include <vector>

namespace midair::samples
{

/// What a plot is drawn of, in pixels from the lower left. It is drawn twice as large and averaged
/// down.
class PlotSheet
{
public:
    PlotSheet();

    void text(const std::string& content,
              const osg::Vec2& at,
              osgText::TextBase::AlignmentType alignment,
              float size,
              const osg::Vec4& color,
              bool isUpright = false);
    /// \a z: what is nearer hides what is farther; -1 .. 1.
    void line(const std::vector<osg::Vec2>& places, const osg::Vec4& color, float width, float z);
    void disc(const osg::Vec2& at, float radius, const osg::Vec4& color, float z);
    void rectangle(const osg::Vec2& low, const osg::Vec2& high, const osg::Vec4& color, float z);

    osg::Group& root() { return *_root; }

    /// Returns the width of \a content in pixels.
    float widthOf(const std::string& content, float size) const;

private:
    osg::ref_ptr<osgText::Text> made(const std::string& content, float size) const;
    void add(const std::vector<osg::Vec2>& places,
             GLenum how,
             const osg::Vec4& color,
             float width,
             float z);

    osg::ref_ptr<osg::Group> _root = new osg::Group;
    osg::ref_ptr<osgText::Font> _font;
};

} // namespace midair::samples
