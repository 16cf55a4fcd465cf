"""Many episodes: what is asked, who drives them, and the folder that keeps them so that a sweep can go on."""
