"""What a camera in a car adds to the picture: bonnet, dirty glass, exposure control, shutter, recording."""
