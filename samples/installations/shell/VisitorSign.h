#pragma once

#include <osg/Camera>
#include <osgText/Text>

#include <string>

namespace midair::samples
{

/// What is always written on the screen, over all else: at its upper left the invitation and what
/// the installation says, at its upper right the mute key and whether the array is muted.
class VisitorSign
{
public:
    VisitorSign();

    osg::Node* node() const { return _camera; }
    /// To be called in each frame. \a width, \a height: of the viewport, pixels.
    void update(double width, double height);

    void setInvitation(const std::string& text) { set(*_invitation, text); }
    void setCaption(const std::string& text) { set(*_caption, text); }
    /// \a trouble: what is wrong with the array, or why it is muted; empty: nothing.
    void setState(bool isMuted, const std::string& trouble);

private:
    static void set(osgText::Text& text, const std::string& content);

    osg::ref_ptr<osg::Camera> _camera;
    osg::ref_ptr<osgText::Text> _invitation;
    osg::ref_ptr<osgText::Text> _caption;
    osg::ref_ptr<osgText::Text> _mute;
    osg::ref_ptr<osgText::Text> _trouble;
};

} // namespace midair::samples
