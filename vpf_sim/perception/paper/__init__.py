"""What the printed method needs: time to contact and the obstacle map."""
